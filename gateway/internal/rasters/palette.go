// SPDX-License-Identifier: Apache-2.0

package rasters

import (
	"image/color"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"
)

// paletteName is how the cells of a picture look.
type paletteName string

const (
	clear paletteName = ""     // white free, black occupied, grey between them; nothing where nothing is known
	nav2  paletteName = "nav2" // as Nav2 saves maps: 254 free, 0 occupied, else 205
)

// Nav2's map saver, by default.
const (
	nav2Free     = 0.25
	nav2Occupied = 0.65
)

func parsePalette(text string) (paletteName, error) {
	switch name := paletteName(text); name {
	case clear, nav2:
		return name, nil
	}
	return "", status.Errorf(codes.InvalidArgument, "palette: %q is not known: leave it out, or say nav2", text)
}

func (p paletteName) colourOf(class int) color.Color {
	switch {
	case class == occupied:
		return color.NRGBA{A: 255}
	case p == nav2 && class == free:
		return color.NRGBA{254, 254, 254, 255}
	case p == nav2:
		return color.NRGBA{205, 205, 205, 255}
	case class == free:
		return color.NRGBA{255, 255, 255, 255}
	}
	return color.NRGBA{}
}

// values has the colour of each value of a cell: 0 is unknown, 1 to 255 the probability of an obstacle.
func (p paletteName) values() color.Palette {
	colours := make(color.Palette, 256)
	colours[0] = p.colourOf(unknown)
	for value := 1; value < 256; value++ {
		probability := float64(value-1) / 254
		grey := uint8(255 - value)
		switch {
		case p == clear:
			colours[value] = color.NRGBA{grey, grey, grey, 255}
		case probability <= nav2Free:
			colours[value] = p.colourOf(free)
		case probability >= nav2Occupied:
			colours[value] = p.colourOf(occupied)
		default:
			colours[value] = p.colourOf(unknown)
		}
	}
	return colours
}
