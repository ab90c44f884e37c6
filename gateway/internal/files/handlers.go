// SPDX-License-Identifier: Apache-2.0

package files

import (
	"bytes"
	"context"
	"encoding/hex"
	"fmt"
	"io"
	"net/http"
	"path"
	"strings"

	"github.com/grpc-ecosystem/grpc-gateway/v2/runtime"
	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "enfilade/gateway/gen/enfilade/v1"
	"enfilade/gateway/internal/rest"
)

type handlers struct {
	maps     pb.MapServiceClient
	areas    pb.MapAreaServiceClient
	graphs   pb.GraphServiceClient
	sessions pb.SessionServiceClient
	ingest   pb.IngestServiceClient
	points   pb.LinkPointServiceClient
	priors   pb.PriorMapServiceClient
	limits   UploadLimits
}

type route struct {
	methods, pattern string
	handle           func(http.ResponseWriter, *http.Request, map[string]string) error
}

// Register adds the routes of files to `mux`; they go before those of the RPCs.
func Register(mux *runtime.ServeMux, server *grpc.ClientConn, limits UploadLimits) error {
	h := &handlers{
		maps: pb.NewMapServiceClient(server), areas: pb.NewMapAreaServiceClient(server), graphs: pb.NewGraphServiceClient(server),
		sessions: pb.NewSessionServiceClient(server), ingest: pb.NewIngestServiceClient(server),
		points: pb.NewLinkPointServiceClient(server), priors: pb.NewPriorMapServiceClient(server), limits: limits,
	}
	routes := []route{
		{"GET", "/v1/{name=sites/*/maps/*}/files", h.listMapFiles},
		{"GET", "/v1/{name=sites/*/maps/*/revisions/*}/files", h.listMapFiles},
		{"GET HEAD", "/v1/{name=sites/*/maps/*/revisions/*}/files/{file}", h.sendMapFile},
		{"GET", "/v1/{name=sites/*/maps/*/aliases/*}/files", h.listMapFiles},
		{"GET HEAD", "/v1/{name=sites/*/maps/*/aliases/*}/files/{file}", h.sendMapFile},
		{"GET HEAD", "/v1/{site=sites/*}/graph.geojson", h.sendGraph},
		{"GET", "/v1/{name=sites/*/sessions/*}/trajectory.csv", h.sendTrajectory},
		{"GET HEAD", "/v1/{parent=sites/*}/blobs/{sha256}", h.sendBlob},
		{"POST", "/v1/{name=sites/*/maps/*}:import", h.importMap},
		{"POST", "/v1/{name=sites/*/linkPoints/*}/evidence", h.attachEvidence},
	}
	routes = append(routes, h.mapAreaRoutes()...)
	for _, route := range append(routes, h.priorMapRoutes()...) {
		handle := route.handle
		for _, method := range strings.Fields(route.methods) {
			err := mux.HandlePath(method, route.pattern, func(w http.ResponseWriter, r *http.Request, path map[string]string) {
				if err := handle(w, r, path); err != nil {
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

// Formats by the name that a client gives: pgm, png, json.
func formatOf(name string) (pb.MapFormat, error) {
	if name == "" {
		name = "pgm"
	}
	format, ok := pb.MapFormat_value["MAP_FORMAT_"+strings.ToUpper(name)]
	if !ok || format == 0 {
		return 0, status.Errorf(codes.InvalidArgument, "format: %q is not one of pgm, png and json", name)
	}
	return pb.MapFormat(format), nil
}

func (h *handlers) openMap(ctx context.Context, name, formatName string) (*export[*pb.ExportMapManifest], error) {
	format, err := formatOf(formatName)
	if err != nil {
		return nil, err
	}
	return openExport(h.maps.ExportMap(ctx, &pb.ExportMapRequest{Name: name, Format: format}))
}

// The files of a map's newest or given revision, or that of an alias, with the paths at which they are found.
func (h *handlers) listMapFiles(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	ctx, cancel := context.WithCancel(rest.ContextOf(r))
	defer cancel()
	format := r.URL.Query().Get("format")
	export, err := h.openMap(ctx, path["name"], format)
	if err != nil {
		return err
	}
	return writeLinks(w, "revision", export.manifest.GetRevision().GetName(), export.manifest.GetFiles(), "format", format)
}

var mediaTypes = map[string]string{
	".json": "application/json", ".pgm": "image/x-portable-graymap", ".png": "image/png", ".yaml": "application/yaml",
}

func (h *handlers) sendMapFile(w http.ResponseWriter, r *http.Request, variables map[string]string) error {
	ctx, cancel := context.WithCancel(rest.ContextOf(r))
	defer cancel()
	format := r.URL.Query().Get("format")
	if format == "" { // the image of a pair may tell
		format = strings.TrimPrefix(path.Ext(variables["file"]), ".")
		if format == "yaml" {
			format = ""
		}
	}
	export, err := h.openMap(ctx, variables["name"], format)
	if err != nil {
		return err
	}
	if export.send(w, r, variables["file"], func(file string) string { return mediaTypes[path.Ext(file)] }) {
		return nil
	}
	return status.Errorf(codes.NotFound, "%s has no file %s in this format", variables["name"], variables["file"])
}

type chunked interface{ GetChunk() *pb.FileChunk }

func chunk[T chunked](response T, err error) (*pb.FileChunk, error) {
	if err != nil {
		return nil, err
	}
	return response.GetChunk(), nil
}

// chunksOf one file; those of the others are passed over.
func chunksOf(index int32, receive func() (*pb.FileChunk, error)) func() ([]byte, error) {
	return func() ([]byte, error) {
		for {
			piece, err := receive()
			if err != nil {
				return nil, err
			}
			if piece.GetFile() == index {
				return piece.GetData(), nil
			}
		}
	}
}

func (h *handlers) sendGraph(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	ctx, cancel := context.WithCancel(rest.ContextOf(r))
	defer cancel()
	stream, err := h.graphs.ExportGraph(ctx, &pb.ExportGraphRequest{
		Site: path["site"], WithoutEdges: r.URL.Query().Get("edges") == "false",
		WithTracks: r.URL.Query().Get("tracks") == "true"})
	if err != nil {
		return err
	}
	first, err := stream.Recv()
	if err != nil {
		return err
	}
	files := first.GetManifest().GetFiles()
	if len(files) == 0 {
		return errNoManifest
	}
	Send(w, r, &File{
		Name: files[0].GetName(), Size: files[0].GetSizeBytes(), SHA256: files[0].GetSha256(),
		MediaType: "application/geo+json",
		Next:      chunksOf(0, func() (*pb.FileChunk, error) { return chunk(stream.Recv()) }),
	})
	return nil
}

// One line a pose: time (s since 1970, UTC), x (m), y (m), yaw (rad), in the session's map.
func (h *handlers) sendTrajectory(w http.ResponseWriter, r *http.Request, variables map[string]string) error {
	stream, err := h.sessions.ExportTrajectory(rest.ContextOf(r), &pb.ExportTrajectoryRequest{Name: variables["name"]})
	if err != nil {
		return err
	}
	part, err := stream.Recv()
	if err != nil && err != io.EOF {
		return err
	}
	w.Header().Set("Content-Type", "text/csv; charset=utf-8")
	w.Header().Set("Cache-Control", "private, no-cache")
	w.Header().Set("Content-Disposition",
		fmt.Sprintf("attachment; filename=%q", path.Base(variables["name"])+".csv"))
	_, _ = io.WriteString(w, "time,x,y,yaw\n")
	var lines bytes.Buffer
	for err == nil {
		lines.Reset()
		for _, pose := range part.GetPoses() {
			at := pose.GetPoseMapRobot()
			fmt.Fprintf(&lines, "%d.%09d,%.6f,%.6f,%.8f\n", pose.GetTime().GetSeconds(), pose.GetTime().GetNanos(),
				at.GetX(), at.GetY(), at.GetYaw())
		}
		if _, writeErr := w.Write(lines.Bytes()); writeErr != nil {
			return nil // the client is gone
		}
		part, err = stream.Recv()
	}
	if err != io.EOF {
		panic(http.ErrAbortHandler)
	}
	return nil
}

// A recorded image or cloud by the digest of its content, in hexadecimal digits.
func (h *handlers) sendBlob(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	digest, err := hex.DecodeString(path["sha256"])
	if err != nil || len(digest) != 32 {
		return status.Errorf(codes.InvalidArgument, "sha256: %q is not 64 hexadecimal digits", path["sha256"])
	}
	ctx, cancel := context.WithCancel(rest.ContextOf(r))
	defer cancel()
	stream, err := h.ingest.DownloadBlob(ctx, &pb.DownloadBlobRequest{Parent: path["parent"], Sha256: digest})
	if err != nil {
		return err
	}
	first, err := stream.Recv()
	if err != nil {
		return err
	}
	pending := first.GetChunk().GetData()
	file := &File{Name: path["sha256"], Size: first.GetChunk().GetBlob().GetSizeBytes(), SHA256: digest, Immutable: true}
	file.MediaType = "application/octet-stream"
	// Of pictures only those that no browser runs anything of.
	if sniffed := http.DetectContentType(pending); sniffed == "image/png" || sniffed == "image/jpeg" {
		file.MediaType, file.Inline = sniffed, true
		file.Name += "." + strings.TrimPrefix(sniffed, "image/")
	}
	file.Next = func() ([]byte, error) {
		if pending != nil {
			piece := pending
			pending = nil
			return piece, nil
		}
		response, err := stream.Recv()
		return response.GetChunk().GetData(), err
	}
	Send(w, r, file)
	return nil
}
