// SPDX-License-Identifier: Apache-2.0

package rasters

import (
	"fmt"
	"image"
	"image/color"
	"math"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "enfilade/gateway/gen/enfilade/v1"
)

// Classes of a cell, of which the greatest wins where maps lie over one another: walls stay.
const (
	unknown = iota
	free
	occupied
)

// pose of frame b in frame a, as T_a_b.
type pose struct{ x, y, yaw float64 }

func poseOf(message *pb.Pose2) pose { return pose{message.GetX(), message.GetY(), message.GetYaw()} }

// apply T_a_b to a point in b.
func (p pose) apply(x, y float64) (float64, float64) {
	sin, cos := math.Sincos(p.yaw)
	return p.x + cos*x - sin*y, p.y + sin*x + cos*y
}

// times is T_a_b T_b_c.
func (p pose) times(q pose) pose {
	x, y := p.apply(q.x, q.y)
	return pose{x, y, p.yaw + q.yaw}
}

// box in the world, metres.
type box struct{ minX, minY, maxX, maxY float64 }

func emptyBox() box { return box{math.Inf(1), math.Inf(1), math.Inf(-1), math.Inf(-1)} }

func (b *box) add(o box) {
	*b = box{min(b.minX, o.minX), min(b.minY, o.minY), max(b.maxX, o.maxX), max(b.maxY, o.maxY)}
}

func (b box) meets(o box) bool {
	return b.minX < o.maxX && o.minX < b.maxX && b.minY < o.maxY && o.minY < b.maxY
}

func (b box) String() string {
	return fmt.Sprintf("%.6g,%.6g,%.6g,%.6g", b.minX, b.minY, b.maxX, b.maxY)
}

// raster is a rectangle of cells, row by row from the lowest.
type raster struct {
	poseWorldCorner pose
	resolution      float64 // metres per cell
	width, height   int
	cells           []byte
}

// corners as the upright box around them.
func (r raster) corners() box {
	bounds := emptyBox()
	width, height := float64(r.width)*r.resolution, float64(r.height)*r.resolution
	for _, corner := range [][2]float64{{0, 0}, {width, 0}, {0, height}, {width, height}} {
		x, y := r.poseWorldCorner.apply(corner[0], corner[1])
		bounds.add(box{x, y, x, y})
	}
	return bounds
}

func thumbnailOf(placed placedMap) raster {
	one := placed.thumbnail
	corner := placed.poseWorldMap.times(poseOf(one.GetPoseMapThumbnail()))
	return raster{corner, one.GetResolutionM(), int(one.GetWidth()), int(one.GetHeight()), one.GetCells()}
}

type placedTile struct {
	raster
	digest []byte
}

// tilesOf the finest zoom whose cells are no smaller than a pixel, so that none of them falls between two pixels; without
// their cells.
func tilesOf(manifest *pb.GetRasterManifestResponse, poseWorldMap pose, pixel float64) []placedTile {
	levels := manifest.GetLevels()
	if len(levels) == 0 {
		return nil
	}
	chosen := levels[len(levels)-1]
	for _, level := range levels {
		if manifest.GetResolutionM()*math.Exp2(float64(level.GetZoom())) >= pixel {
			chosen = level
			break
		}
	}
	resolution := manifest.GetResolutionM() * math.Exp2(float64(chosen.GetZoom()))
	origin := poseWorldMap.times(poseOf(manifest.GetPoseMapTiles()))
	tiles := make([]placedTile, 0, len(chosen.GetTiles()))
	for _, tile := range chosen.GetTiles() {
		side := resolution * TileSide
		corner := origin.times(pose{x: float64(tile.GetColumn()) * side, y: float64(tile.GetRow()) * side})
		tiles = append(tiles, placedTile{raster{corner, resolution, TileSide, TileSide, nil}, tile.GetSha256()})
	}
	return tiles
}

// canvas is a picture under way: a class for each pixel, the highest row first.
type canvas struct {
	bounds        box
	width, height int
	pixel         float64 // metres
	classes       []uint8
}

func newCanvas(bounds box, width int) (*canvas, error) {
	pixel := (bounds.maxX - bounds.minX) / float64(width)
	height := math.Ceil((bounds.maxY-bounds.minY)/pixel - 1e-9)
	if height > maxSide {
		return nil, status.Errorf(codes.InvalidArgument,
			"width: with %d pixels the picture is %.0f pixels high, more than %d", width, height, maxSide)
	}
	return &canvas{bounds, width, int(height), pixel, make([]uint8, width*int(height))}, nil
}

// draw a raster. `classes`: of each value of a cell; nil: the cells are classes.
func (c *canvas) draw(r raster, classes []byte) {
	c.sample(r, classes)
	if r.resolution < c.pixel {
		c.stampWalls(r, classes)
	}
}

// sample the cell under the centre of each pixel.
func (c *canvas) sample(r raster, classes []byte) {
	around := r.corners()
	firstX := max(0, int(math.Floor((around.minX-c.bounds.minX)/c.pixel)))
	endX := min(c.width, int(math.Ceil((around.maxX-c.bounds.minX)/c.pixel))+1)
	firstY := max(0, int(math.Floor((c.bounds.maxY-around.maxY)/c.pixel)))
	endY := min(c.height, int(math.Ceil((c.bounds.maxY-around.minY)/c.pixel))+1)
	sin, cos := math.Sincos(r.poseWorldCorner.yaw)
	for y := firstY; y < endY; y++ {
		dy := c.bounds.maxY - (float64(y)+0.5)*c.pixel - r.poseWorldCorner.y
		for x := firstX; x < endX; x++ {
			dx := c.bounds.minX + (float64(x)+0.5)*c.pixel - r.poseWorldCorner.x
			column := int(math.Floor((cos*dx + sin*dy) / r.resolution))
			row := int(math.Floor((cos*dy - sin*dx) / r.resolution))
			if column >= 0 && column < r.width && row >= 0 && row < r.height {
				c.set(x, y, classOf(r.cells[row*r.width+column], classes))
			}
		}
	}
}

// stampWalls whose cells may lie between the centres of pixels.
func (c *canvas) stampWalls(r raster, classes []byte) {
	for i, value := range r.cells {
		if classOf(value, classes) != occupied {
			continue
		}
		x, y := r.poseWorldCorner.apply((float64(i%r.width)+0.5)*r.resolution, (float64(i/r.width)+0.5)*r.resolution)
		column := int(math.Floor((x - c.bounds.minX) / c.pixel))
		row := int(math.Floor((c.bounds.maxY - y) / c.pixel))
		if column >= 0 && column < c.width && row >= 0 && row < c.height {
			c.set(column, row, occupied)
		}
	}
}

func classOf(value byte, classes []byte) byte {
	if classes == nil {
		return value
	}
	return classes[value]
}

func (c *canvas) set(x, y int, class byte) {
	if at := &c.classes[y*c.width+x]; class > *at {
		*at = class
	}
}

func (c *canvas) picture(name paletteName) image.Image {
	picture := &image.Paletted{Pix: c.classes, Stride: c.width, Rect: image.Rect(0, 0, c.width, c.height)}
	picture.Palette = color.Palette{name.colourOf(unknown), name.colourOf(free), name.colourOf(occupied)}
	return picture
}
