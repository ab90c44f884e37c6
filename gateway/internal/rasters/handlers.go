// SPDX-License-Identifier: Apache-2.0

package rasters

import (
	"compress/gzip"
	"context"
	"crypto/sha256"
	"encoding/binary"
	"encoding/hex"
	"encoding/json"
	"fmt"
	"image"
	"image/png"
	"io"
	"net/http"
	"strconv"
	"strings"
	"time"

	"github.com/grpc-ecosystem/grpc-gateway/v2/runtime"
	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"
	"google.golang.org/protobuf/encoding/protojson"
	"google.golang.org/protobuf/proto"

	pb "enfilade/gateway/gen/enfilade/v1"
	"enfilade/gateway/internal/answer"
	"enfilade/gateway/internal/cache"
	"enfilade/gateway/internal/rest"
)

const (
	callTime    = 30 * time.Second
	cacheBytes  = 64 << 20
	cacheKept   = time.Minute
	maxTiles    = 256
	maxJSONBody = 1 << 20
)

type handlers struct {
	rasters pb.RasterServiceClient
	graphs  pb.GraphServiceClient
	cache   *cache.Cache[[]byte]
}

// Register adds the routes of tiles and pictures to `mux`; they go before those of the RPCs.
func Register(mux *runtime.ServeMux, server *grpc.ClientConn) error {
	h := &handlers{pb.NewRasterServiceClient(server), pb.NewGraphServiceClient(server), cache.New(cacheBytes, cacheKept, func(content []byte) int { return len(content) })}
	for _, route := range []struct {
		methods, pattern string
		handle           func(http.ResponseWriter, *http.Request, map[string]string) error
	}{
		{"GET HEAD", "/v1/{name=sites/*/maps/*/revisions/*}/manifest", h.sendManifest},
		{"GET HEAD", "/v1/{site=sites/*}/tiles/{sha256}", h.sendTileOrPicture},
		{"POST", "/v1/{site=sites/*}/tiles:batch", h.sendBatch},
		{"GET HEAD", "/v1/{site=sites/*}/overview", h.sendOverview},
		{"GET HEAD", "/v1/{site=sites/*}/composite.png", h.sendComposite},
	} {
		handle := route.handle
		for _, method := range strings.Fields(route.methods) {
			err := mux.HandlePath(method, route.pattern, func(w http.ResponseWriter, r *http.Request, path map[string]string) {
				if err := handle(w, r, path); err != nil {
					w.Header().Del("Content-Encoding")
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

// The manifest as the RPC's JSON, which never changes.
func (h *handlers) sendManifest(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	ctx, cancel := context.WithTimeout(rest.ContextOf(r), callTime)
	defer cancel()
	manifest, err := h.rasters.GetRasterManifest(ctx, &pb.GetRasterManifestRequest{Name: path["name"]})
	if err != nil {
		return err
	}
	encoded, err := proto.MarshalOptions{Deterministic: true}.Marshal(manifest)
	if err != nil {
		return err
	}
	digest := sha256.Sum256(encoded)
	if answer.Immutable(w, r, hex.EncodeToString(digest[:])) {
		return nil
	}
	body, err := protojson.MarshalOptions{EmitDefaultValues: true}.Marshal(manifest)
	if err != nil {
		return err
	}
	w.Header().Set("Content-Type", "application/json")
	return answer.SendCompressed(w, r, body)
}

func (h *handlers) sendTileOrPicture(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	digest, isPicture := strings.CutSuffix(path["sha256"], ".png")
	if !isPicture {
		return h.sendTile(w, r, path)
	}
	palette, err := parsePalette(r.URL.Query().Get("palette"))
	if err != nil {
		return err
	}
	frame, err := h.frameOf(rest.ContextOf(r), path["site"], digest)
	if err != nil {
		return err
	}
	if answer.Immutable(w, r, strings.ToLower(digest)+".png"+string(palette)) {
		return nil
	}
	cells, err := inflate(frame)
	if err != nil {
		return err
	}
	w.Header().Set("Content-Type", "image/png")
	if r.Method == http.MethodHead {
		return nil
	}
	_ = (&png.Encoder{CompressionLevel: png.BestSpeed}).Encode(w, pictureOf(cells, palette)) // else the client is gone
	return nil
}

// pictureOf a tile. The highest row comes first.
func pictureOf(cells []byte, name paletteName) image.Image {
	picture := image.NewPaletted(image.Rect(0, 0, TileSide, TileSide), name.values())
	for row := range TileSide {
		copy(picture.Pix[(TileSide-1-row)*picture.Stride:], cells[row*TileSide:(row+1)*TileSide])
	}
	return picture
}

type batchRequest struct {
	SHA256 []string `json:"sha256"`
}

// Tiles one after the other: 32 bytes SHA-256, 4 bytes length (little-endian), and so many bytes of cells, or with
// "?encoding=zstd" of a Zstandard frame of them.
func (h *handlers) sendBatch(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	var request batchRequest
	reader := json.NewDecoder(http.MaxBytesReader(w, r.Body, maxJSONBody))
	reader.DisallowUnknownFields()
	if err := reader.Decode(&request); err != nil {
		return status.Errorf(codes.InvalidArgument, "the body is not {\"sha256\": [...]}: %v", err)
	}
	if len(request.SHA256) == 0 || len(request.SHA256) > maxTiles {
		return status.Errorf(codes.InvalidArgument, "sha256 has %d values: expected 1 to %d", len(request.SHA256), maxTiles)
	}
	digests := make([][]byte, 0, len(request.SHA256))
	for _, text := range request.SHA256 {
		digest, err := digestOf(text)
		if err != nil {
			return err
		}
		digests = append(digests, digest)
	}
	isRaw := r.URL.Query().Get("encoding") != "zstd"
	begun := false
	var out io.Writer = w
	if isRaw && answer.Accepts(r, "gzip") {
		writer := answer.Writers.Get().(*gzip.Writer)
		defer answer.Writers.Put(writer)
		writer.Reset(w)
		out = writer
	}
	err := h.readTiles(rest.ContextOf(r), path["site"], digests, func(digest, content []byte) error {
		if isRaw {
			cells, err := inflate(content)
			if err != nil {
				return err
			}
			content = cells
		}
		if !begun {
			w.Header().Set("Content-Type", "application/octet-stream")
			w.Header().Set("Cache-Control", "no-store")
			if out != w {
				w.Header().Set("Content-Encoding", "gzip")
			}
			begun = true
		}
		frame := binary.LittleEndian.AppendUint32(append([]byte{}, digest...), uint32(len(content)))
		_, err := out.Write(append(frame, content...))
		return err
	})
	if err != nil && begun {
		panic(http.ErrAbortHandler) // nobody must take a part for the whole
	}
	if writer, ok := out.(*gzip.Writer); ok && begun {
		_ = writer.Close() // else the client is gone
	}
	return err
}

// All thumbnails of a site, or of one level: a line of JSON with the index, then the cells of all of them.
func (h *handlers) sendOverview(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	request := &pb.ListRasterThumbnailsRequest{Parent: path["site"], PageSize: 1000}
	if text := r.URL.Query().Get("level"); text != "" {
		level, err := strconv.ParseInt(text, 10, 32)
		if err != nil {
			return status.Errorf(codes.InvalidArgument, "level: %q is not a number", text)
		}
		request.Level = proto.Int32(int32(level))
	}
	thumbnails, err := h.listThumbnails(rest.ContextOf(r), request)
	if err != nil {
		return err
	}
	body, err := encodeOverview(thumbnails)
	if err != nil {
		return err
	}
	digest := sha256.Sum256(body)
	w.Header().Set("Cache-Control", "private, no-cache")
	if answer.Has(w, r, hex.EncodeToString(digest[:])) {
		return nil
	}
	w.Header().Set("Content-Type", "application/octet-stream")
	return answer.SendCompressed(w, r, body)
}

func (h *handlers) listThumbnails(ctx context.Context, request *pb.ListRasterThumbnailsRequest) ([]*pb.RasterThumbnail, error) {
	var thumbnails []*pb.RasterThumbnail
	for {
		call, cancel := context.WithTimeout(ctx, callTime)
		page, err := h.rasters.ListRasterThumbnails(call, request)
		cancel()
		if err != nil {
			return nil, err
		}
		thumbnails = append(thumbnails, page.GetThumbnails()...)
		if request.PageToken = page.GetNextPageToken(); request.PageToken == "" {
			return thumbnails, nil
		}
	}
}

type overviewEntry struct {
	Revision    string  `json:"revision"`
	ResolutionM float64 `json:"resolutionM"`
	X           float64 `json:"x"`
	Y           float64 `json:"y"`
	Yaw         float64 `json:"yaw"`
	Width       int32   `json:"width"`
	Height      int32   `json:"height"`
	Offset      int     `json:"offset"`
}

func encodeOverview(thumbnails []*pb.RasterThumbnail) ([]byte, error) {
	entries := make([]overviewEntry, 0, len(thumbnails))
	var cells []byte
	for _, one := range thumbnails {
		pose := one.GetPoseMapThumbnail()
		entries = append(entries, overviewEntry{one.GetRevision(), one.GetResolutionM(), pose.GetX(), pose.GetY(),
			pose.GetYaw(), one.GetWidth(), one.GetHeight(), len(cells)})
		cells = append(cells, one.GetCells()...)
	}
	index, err := json.Marshal(map[string]any{"thumbnails": entries})
	if err != nil {
		return nil, err
	}
	return append(append(index, '\n'), cells...), nil
}
