// SPDX-License-Identifier: Apache-2.0

// Package vectors serves link points, outlines of maps and tracks of robots as Mapbox Vector Tiles, for other programs.
package vectors

import (
	"context"
	"encoding/json"
	"fmt"
	"net/http"
	"strconv"
	"strings"
	"time"

	"github.com/grpc-ecosystem/grpc-gateway/v2/runtime"
	"github.com/paulmach/orb"
	"github.com/paulmach/orb/encoding/mvt"
	"github.com/paulmach/orb/geojson"
	"github.com/paulmach/orb/maptile"
	"golang.org/x/sync/singleflight"
	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "enfilade/gateway/gen/enfilade/v1"
	"enfilade/gateway/internal/answer"
	"enfilade/gateway/internal/cache"
	"enfilade/gateway/internal/rest"
)

const (
	callTime   = 30 * time.Second
	cacheBytes = 64 << 20 // of exported files
	cacheKept  = 10 * time.Minute
	// How long the newest version is taken for the newest when older ones are asked for.
	newestKept = time.Second
	maxZoom    = 24
	mediaType  = "application/vnd.mapbox-vector-tile"
	// Beyond a tile's edge, of its side: what is drawn with some width must not end there.
	margin = 1.0 / 64
)

type handlers struct {
	graphs  pb.GraphServiceClient
	kept    *cache.Cache[*layers] // by site and version
	newest  *cache.Cache[*layers] // by site
	reading singleflight.Group
}

// Register adds the routes of vector tiles to `mux`; they go before those of the RPCs.
func Register(mux *runtime.ServeMux, server *grpc.ClientConn) error {
	bytesOf := func(one *layers) int { return one.bytes }
	h := &handlers{graphs: pb.NewGraphServiceClient(server), kept: cache.New(cacheBytes, cacheKept, bytesOf),
		newest: cache.New(cacheBytes, newestKept, bytesOf)}
	for _, route := range []struct {
		pattern string
		handle  func(http.ResponseWriter, *http.Request, map[string]string) error
	}{
		{"/v1/{site=sites/*}/mvt.json", h.describe},
		{"/v1/{site=sites/*}/mvt/{version}/{z}/{x}/{y}", h.sendTile},
	} {
		for _, method := range []string{http.MethodGet, http.MethodHead} {
			err := mux.HandlePath(method, route.pattern, func(w http.ResponseWriter, r *http.Request, path map[string]string) {
				if err := route.handle(w, r, path); err != nil {
					rest.WriteError(w, r, err)
				}
			})
			if err != nil {
				return fmt.Errorf("%s %s: %w", method, route.pattern, err)
			}
		}
	}
	return nil
}

// readNewest reads once for all who ask at the same time.
func (h *handlers) readNewest(r *http.Request, site string) (*layers, error) {
	result, err, _ := h.reading.Do(site, func() (any, error) {
		// Others wait for it, too: it does not end with this request.
		ctx, cancel := context.WithTimeout(context.WithoutCancel(rest.ContextOf(r)), callTime)
		defer cancel()
		read, err := h.read(ctx, site)
		if err != nil {
			return nil, err
		}
		h.newest.Put(site, read)
		h.kept.Put(keyOf(site, read.version), read)
		return read, nil
	})
	if err != nil {
		return nil, err
	}
	return result.(*layers), nil
}

func keyOf(site string, version int64) string { return site + "@" + strconv.FormatInt(version, 10) }

func (h *handlers) layersAt(r *http.Request, site string, version int64) (*layers, error) {
	if found, ok := h.kept.Get(keyOf(site, version)); ok {
		return found, nil
	}
	newest, ok := h.newest.Get(site)
	if !ok || version > newest.version {
		var err error
		if newest, err = h.readNewest(r, site); err != nil {
			return nil, err
		}
	}
	if newest.version != version {
		return nil, status.Errorf(codes.NotFound, "version %d of the graph is not kept: the newest is %d, see mvt.json",
			version, newest.version)
	}
	return newest, nil
}

type tileJSON struct {
	TileJSON     string           `json:"tilejson"`
	Name         string           `json:"name"`
	Version      string           `json:"version"`
	Tiles        []string         `json:"tiles"`
	MinZoom      int              `json:"minzoom"`
	MaxZoom      int              `json:"maxzoom"`
	Bounds       [4]float64       `json:"bounds"`
	VectorLayers []map[string]any `json:"vector_layers"`
}

// TileJSON 3.0 of the newest version: where a map program begins.
func (h *handlers) describe(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	newest, err := h.readNewest(r, path["site"])
	if err != nil {
		return err
	}
	scheme := "http"
	if r.TLS != nil {
		scheme = "https"
	}
	body := tileJSON{TileJSON: "3.0.0", Name: path["site"], Version: fmt.Sprintf("%d.0.0", newest.version), MaxZoom: maxZoom,
		Tiles:  []string{fmt.Sprintf("%s://%s/v1/%s/mvt/%d/{z}/{x}/{y}.mvt", scheme, r.Host, path["site"], newest.version)},
		Bounds: [4]float64{newest.bound.Left(), newest.bound.Bottom(), newest.bound.Right(), newest.bound.Top()}}
	for _, name := range []string{linkPoints, outlines, tracks} {
		body.VectorLayers = append(body.VectorLayers, map[string]any{"id": name, "fields": map[string]string{}})
	}
	encoded, err := json.Marshal(body)
	if err != nil {
		return err
	}
	w.Header().Set("Content-Type", "application/json")
	w.Header().Set("Cache-Control", "private, no-cache")
	return answer.Send(w, r, encoded)
}

func tileOf(path map[string]string) (int64, maptile.Tile, error) {
	wrong := status.Error(codes.InvalidArgument, "the address of a tile ends in VERSION/Z/X/Y.mvt, with Z from 0 to 24 and X and Y below 2^Z")
	y, isTile := strings.CutSuffix(path["y"], ".mvt")
	if !isTile {
		return 0, maptile.Tile{}, wrong
	}
	var numbers [4]int64
	for i, text := range []string{path["version"], path["z"], path["x"], y} {
		number, err := strconv.ParseInt(text, 10, 64)
		if err != nil || number < 0 {
			return 0, maptile.Tile{}, wrong
		}
		numbers[i] = number
	}
	if numbers[1] > maxZoom || numbers[2]>>numbers[1] != 0 || numbers[3]>>numbers[1] != 0 {
		return 0, maptile.Tile{}, wrong
	}
	return numbers[0], maptile.New(uint32(numbers[2]), uint32(numbers[3]), maptile.Zoom(numbers[1])), nil
}

func (h *handlers) sendTile(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	version, tile, err := tileOf(path)
	if err != nil {
		return err
	}
	layers, err := h.layersAt(r, path["site"], version)
	if err != nil {
		return err
	}
	if answer.Immutable(w, r, fmt.Sprintf("%d/%d/%d/%d", version, tile.Z, tile.X, tile.Y)) {
		return nil
	}
	encoded, err := mvt.Marshal(layers.cut(tile))
	if err != nil {
		return fmt.Errorf("encoding a tile: %w", err)
	}
	w.Header().Set("Content-Type", mediaType)
	return answer.SendCompressed(w, r, encoded)
}

// cut out what a tile shows.
func (l *layers) cut(tile maptile.Tile) mvt.Layers {
	bound := tile.Bound(margin)
	var result mvt.Layers
	for _, name := range []string{outlines, tracks, linkPoints} {
		collection := geojson.NewFeatureCollection()
		for _, one := range l.features[name] {
			if one.bound.Intersects(bound) {
				copied := geojson.NewFeature(orb.Clone(one.geometry))
				copied.Properties = one.properties
				collection.Append(copied)
			}
		}
		layer := mvt.NewLayer(name, collection)
		layer.Version = 2
		layer.ProjectToTile(tile)
		layer.Clip(mvt.MapboxGLDefaultExtentBound)
		layer.RemoveEmpty(0, 0)
		result = append(result, layer)
	}
	return result
}
