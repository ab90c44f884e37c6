// SPDX-License-Identifier: Apache-2.0

package vectors

import (
	"context"
	"encoding/json"
	"fmt"
	"io"
	"slices"
	"strings"

	"github.com/paulmach/orb"
	"github.com/paulmach/orb/geojson"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "enfilade/gateway/gen/enfilade/v1"
)

// Layers of a tile, and the kinds of the features of the exported graph that are in each.
var layerOf = map[string]string{
	"map": outlines, "link_point": linkPoints, "link_point_candidate": linkPoints, "track": tracks,
}

const (
	outlines   = "outlines"
	linkPoints = "link_points"
	tracks     = "tracks"
)

// layers of a site's graph at one version, in longitude and latitude.
type layers struct {
	version  int64
	features map[string][]feature
	bound    orb.Bound
	bytes    int // of the exported file
}

type feature struct {
	bound      orb.Bound
	geometry   orb.Geometry
	properties geojson.Properties
}

// read what the server exports, whose projection is the only one.
func (h *handlers) read(ctx context.Context, site string) (*layers, error) {
	stream, err := h.graphs.ExportGraph(ctx, &pb.ExportGraphRequest{Site: site, WithoutEdges: true, WithTracks: true})
	if err != nil {
		return nil, err
	}
	first, err := stream.Recv()
	if err != nil {
		return nil, err
	}
	var file []byte
	for {
		part, err := stream.Recv()
		if err == io.EOF {
			return parse(site, first.GetManifest().GetGraphVersion(), file)
		}
		if err != nil {
			return nil, err
		}
		file = append(file, part.GetChunk().GetData()...)
	}
}

func parse(site string, version int64, file []byte) (*layers, error) {
	var frame struct{ Frame string }
	if err := json.Unmarshal(file, &frame); err != nil {
		return nil, fmt.Errorf("the exported graph: %w", err)
	}
	if frame.Frame != "" {
		return nil, status.Errorf(codes.NotFound, "%s has no georeference: its places on the globe are not known", site)
	}
	collection, err := geojson.UnmarshalFeatureCollection(file)
	if err != nil {
		return nil, fmt.Errorf("the exported graph: %w", err)
	}
	result := &layers{version: version, features: map[string][]feature{}, bytes: len(file)}
	for _, one := range collection.Features {
		layer := layerOf[one.Properties.MustString("kind", "")]
		_, isPoint := one.Geometry.(orb.Point)
		// A map without an outline is exported as the point of its origin.
		if layer == "" || one.Geometry == nil || (layer == outlines && isPoint) {
			continue
		}
		bound := one.Geometry.Bound()
		if len(result.features) == 0 {
			result.bound = bound
		}
		result.bound = result.bound.Union(bound)
		result.features[layer] = append(result.features[layer], feature{bound, one.Geometry, flattened(one.Properties)})
	}
	return result, nil
}

// flattened properties: tiles have no lists and no nulls.
func flattened(properties geojson.Properties) geojson.Properties {
	for name, value := range properties {
		switch value := value.(type) {
		case nil:
			delete(properties, name)
		case []any:
			texts := make([]string, 0, len(value))
			for _, one := range value {
				texts = append(texts, fmt.Sprint(one))
			}
			slices.Sort(texts)
			properties[name] = strings.Join(texts, ",")
		}
	}
	return properties
}
