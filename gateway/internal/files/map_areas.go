// SPDX-License-Identifier: Apache-2.0

package files

import (
	"context"
	"net/http"
	"net/url"
	"strings"
	"time"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"
	"google.golang.org/protobuf/types/known/timestamppb"

	pb "enfilade/gateway/gen/enfilade/v1"
	"enfilade/gateway/internal/rest"
)

func (h *handlers) mapAreaRoutes() []route {
	return []route{
		{"GET", "/v1/{parent=sites/*/maps/*}/areas/files", h.listAreaFiles},
		{"GET HEAD", "/v1/{parent=sites/*/maps/*}/areas/files/{file}", h.sendAreaFile},
	}
}

// Formats by the name that a client gives: those of `enfilade area export`.
var areaFormats = map[string]pb.MapAreaFormat{
	"":             pb.MapAreaFormat_MAP_AREA_FORMAT_GEOJSON,
	"geojson":      pb.MapAreaFormat_MAP_AREA_FORMAT_GEOJSON,
	"nav2-keepout": pb.MapAreaFormat_MAP_AREA_FORMAT_NAV2_KEEPOUT,
	"nav2-speed":   pb.MapAreaFormat_MAP_AREA_FORMAT_NAV2_SPEED,
}

var formatOfAreaFile = map[string]string{
	"areas.geojson": "geojson", "keepout.pgm": "nav2-keepout", "keepout.yaml": "nav2-keepout",
	"speed.pgm": "nav2-speed", "speed.yaml": "nav2-speed",
}

var areaMediaTypes = map[string]string{
	".geojson": "application/geo+json", ".pgm": "image/x-portable-graymap", ".yaml": "application/yaml",
}

func areaMediaType(file string) string { return areaMediaTypes[file[strings.LastIndex(file, "."):]] }

func (h *handlers) openAreas(ctx context.Context, parent, formatName string, query url.Values) (*export[*pb.ExportMapAreasManifest], error) {
	format, ok := areaFormats[formatName]
	if !ok {
		return nil, status.Errorf(codes.InvalidArgument,
			"format: %q is not one of geojson, nav2-keepout and nav2-speed", formatName)
	}
	request := &pb.ExportMapAreasRequest{Parent: parent, Format: format, RobotType: query.Get("robotType")}
	if text := query.Get("time"); text != "" {
		at, err := time.Parse(time.RFC3339Nano, text)
		if err != nil {
			return nil, status.Errorf(codes.InvalidArgument, "time: %q is not a time as in 2026-01-31T08:00:00Z", text)
		}
		request.Time = timestamppb.New(at)
	}
	return openExport(h.areas.ExportMapAreas(ctx, request))
}

// The files of a map's areas in a format, with the paths at which they are found. They change with the areas, and masks
// with the map's revision.
func (h *handlers) listAreaFiles(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	ctx, cancel := context.WithCancel(rest.ContextOf(r))
	defer cancel()
	query := r.URL.Query()
	export, err := h.openAreas(ctx, path["parent"], query.Get("format"), query)
	if err != nil {
		return err
	}
	options := url.Values{} // the file's name says its format
	for _, option := range []string{"robotType", "time"} {
		if value := query.Get(option); value != "" {
			options.Set(option, value)
		}
	}
	return writeLinksAt(w, "map", path["parent"], path["parent"]+"/areas", export.manifest.GetFiles(), options)
}

func (h *handlers) sendAreaFile(w http.ResponseWriter, r *http.Request, variables map[string]string) error {
	ctx, cancel := context.WithCancel(rest.ContextOf(r))
	defer cancel()
	format, ok := formatOfAreaFile[variables["file"]]
	if !ok {
		return status.Errorf(codes.NotFound, "%s/areas has no file %s: it has areas.geojson, keepout.pgm, keepout.yaml, "+
			"speed.pgm and speed.yaml", variables["parent"], variables["file"])
	}
	export, err := h.openAreas(ctx, variables["parent"], format, r.URL.Query())
	if err != nil {
		return err
	}
	if export.send(w, r, variables["file"], areaMediaType) {
		return nil
	}
	return status.Errorf(codes.NotFound, "%s/areas has no file %s", variables["parent"], variables["file"])
}
