// SPDX-License-Identifier: Apache-2.0

package rasters

import (
	"bytes"
	"context"
	"crypto/sha256"
	"encoding/hex"
	"fmt"
	"image/png"
	"math"
	"net/http"
	"net/url"
	"strconv"
	"strings"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "enfilade/gateway/gen/enfilade/v1"
	"enfilade/gateway/internal/answer"
	"enfilade/gateway/internal/rest"
)

const (
	defaultWidth = 1024
	maxSide      = 4096 // pixels
)

// compositeRequest is what the query of composite.png asks for.
type compositeRequest struct {
	level   *int32
	bounds  *box // unset: all that is drawn
	width   int
	palette paletteName
}

func parseComposite(query url.Values) (compositeRequest, error) {
	request := compositeRequest{width: defaultWidth}
	var err error
	if request.palette, err = parsePalette(query.Get("palette")); err != nil {
		return request, err
	}
	if text := query.Get("level"); text != "" {
		level, err := strconv.ParseInt(text, 10, 32)
		if err != nil {
			return request, status.Errorf(codes.InvalidArgument, "level: %q is not a number", text)
		}
		number := int32(level)
		request.level = &number
	}
	if text := query.Get("width"); text != "" {
		if request.width, err = strconv.Atoi(text); err != nil || request.width < 1 || request.width > maxSide {
			return request, status.Errorf(codes.InvalidArgument, "width: %q is not a number from 1 to %d", text, maxSide)
		}
	}
	if text := query.Get("bbox_world"); text != "" {
		bounds, err := parseBox(text)
		if err != nil {
			return request, err
		}
		request.bounds = &bounds
	}
	return request, nil
}

func parseBox(text string) (box, error) {
	wrong := status.Errorf(codes.InvalidArgument,
		"bbox_world: %q is not min_x,min_y,max_x,max_y in metres of the world frame", text)
	parts := strings.Split(text, ",")
	if len(parts) != 4 {
		return box{}, wrong
	}
	var numbers [4]float64
	for i, part := range parts {
		number, err := strconv.ParseFloat(strings.TrimSpace(part), 64)
		if err != nil || math.IsNaN(number) || math.Abs(number) > 1e9 {
			return box{}, wrong
		}
		numbers[i] = number
	}
	bounds := box{numbers[0], numbers[1], numbers[2], numbers[3]}
	if bounds.maxX-bounds.minX < 1e-3 || bounds.maxY-bounds.minY < 1e-3 {
		return box{}, wrong
	}
	return bounds, nil
}

// The maps of a site as one picture, as the graph places them: for reports, other programs, and browsers without WebGL.
func (h *handlers) sendComposite(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	request, err := parseComposite(r.URL.Query())
	if err != nil {
		return err
	}
	ctx, cancel := context.WithTimeout(rest.ContextOf(r), callTime)
	defer cancel()
	scene, err := h.readScene(ctx, path["site"], request.level)
	if err != nil {
		return err
	}
	bounds := scene.bounds()
	if request.bounds != nil {
		bounds = *request.bounds
	}
	canvas, err := newCanvas(bounds, request.width)
	if err != nil {
		return err
	}
	header := w.Header()
	header.Set("Cache-Control", "private, no-cache")
	header.Set("Enfilade-Graph-Version", fmt.Sprintf("%s=%d", path["site"], scene.graphVersion))
	header.Set("Enfilade-Bbox-World", bounds.String())
	if answer.Has(w, r, scene.tag(canvas, request.palette)) {
		return nil
	}
	for _, placed := range scene.maps {
		if err := h.draw(ctx, path["site"], placed, canvas); err != nil {
			return err
		}
	}
	var encoded bytes.Buffer
	if err := (&png.Encoder{CompressionLevel: png.BestSpeed}).Encode(&encoded, canvas.picture(request.palette)); err != nil {
		return err
	}
	header.Set("Content-Type", "image/png")
	return answer.Send(w, r, encoded.Bytes())
}

// scene is what a picture shows: maps that have a revision and a place in the world.
type scene struct {
	graphVersion int64
	maps         []placedMap
}

type placedMap struct {
	poseWorldMap pose
	thumbnail    *pb.RasterThumbnail
}

func (h *handlers) readScene(ctx context.Context, site string, level *int32) (*scene, error) {
	thumbnails, err := h.listThumbnails(ctx, &pb.ListRasterThumbnailsRequest{Parent: site, PageSize: 1000, Level: level})
	if err != nil {
		return nil, err
	}
	poses := map[string]pose{}
	request := &pb.GetGraphRequest{Site: site, PageSize: 1000}
	result := &scene{}
	for {
		page, err := h.graphs.GetGraph(ctx, request)
		if err != nil {
			return nil, err
		}
		result.graphVersion = page.GetGraph().GetGraphVersion()
		for _, one := range page.GetGraph().GetMaps() {
			if place := one.GetPoseWorldMap().GetPose(); place != nil {
				poses[one.GetMap()] = poseOf(place)
			}
		}
		request.PageToken = page.GetNextPageToken()
		// Link points come behind all maps.
		if request.PageToken == "" || len(page.GetGraph().GetLinkPoints()) > 0 {
			break
		}
	}
	for _, thumbnail := range thumbnails {
		name, _, _ := strings.Cut(thumbnail.GetRevision(), "/revisions/")
		if place, ok := poses[name]; ok {
			result.maps = append(result.maps, placedMap{place, thumbnail})
		}
	}
	return result, nil
}

// bounds of all that is drawn; a metre around the origin if that is nothing.
func (s *scene) bounds() box {
	bounds := emptyBox()
	for _, placed := range s.maps {
		bounds.add(thumbnailOf(placed).corners())
	}
	if len(s.maps) == 0 {
		return box{-1, -1, 1, 1}
	}
	return bounds
}

// tag names what the picture is made of.
func (s *scene) tag(canvas *canvas, palette paletteName) string {
	digest := sha256.New()
	_, _ = fmt.Fprintln(digest, s.graphVersion, canvas.bounds, canvas.width, palette)
	for _, placed := range s.maps {
		_, _ = fmt.Fprintln(digest, placed.thumbnail.GetRevision(), placed.poseWorldMap)
	}
	return hex.EncodeToString(digest.Sum(nil)[:16])
}

// draw a map: by its thumbnail if that is fine enough, else by those of its tiles that the picture shows.
func (h *handlers) draw(ctx context.Context, site string, placed placedMap, canvas *canvas) error {
	if err := ctx.Err(); err != nil {
		return status.FromContextError(err).Err()
	}
	thumbnail := thumbnailOf(placed)
	if !canvas.bounds.meets(thumbnail.corners()) {
		return nil
	}
	if thumbnail.resolution <= canvas.pixel {
		canvas.draw(thumbnail, nil)
		return nil
	}
	manifest, err := h.rasters.GetRasterManifest(ctx, &pb.GetRasterManifestRequest{Name: placed.thumbnail.GetRevision()})
	if err != nil {
		return err
	}
	shown := map[string][]raster{} // by digest: a tile may be in several places
	var digests [][]byte
	for _, tile := range tilesOf(manifest, placed.poseWorldMap, canvas.pixel) {
		if canvas.bounds.meets(tile.corners()) {
			if shown[string(tile.digest)] == nil {
				digests = append(digests, tile.digest)
			}
			shown[string(tile.digest)] = append(shown[string(tile.digest)], tile.raster)
		}
	}
	for begin := 0; begin < len(digests); begin += maxTiles {
		err := h.readTiles(ctx, site, digests[begin:min(begin+maxTiles, len(digests))], func(digest, frame []byte) error {
			cells, err := inflate(frame)
			if err != nil {
				return err
			}
			for _, tile := range shown[string(digest)] {
				tile.cells = cells
				canvas.draw(tile, manifest.GetClasses())
			}
			return nil
		})
		if err != nil {
			return err
		}
	}
	return nil
}
