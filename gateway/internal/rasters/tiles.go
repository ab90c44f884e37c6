// SPDX-License-Identifier: Apache-2.0

// Package rasters serves the rasters of maps as tiles and pictures, with the caching that content-addressed tiles allow.
package rasters

import (
	"bytes"
	"compress/gzip"
	"context"
	"encoding/hex"
	"io"
	"net/http"
	"strings"
	"sync"

	"github.com/klauspost/compress/zstd"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "enfilade/gateway/gen/enfilade/v1"
)

// TileSide is the width and height of a tile in cells; a cell is one byte.
const TileSide = 256

const tileBytes = TileSide * TileSide

// decoder takes no more than a tile from a frame, whatever the frame says. It may be used by several calls at once.
var decoder = sync.OnceValues(func() (*zstd.Decoder, error) {
	return zstd.NewReader(nil, zstd.WithDecoderMaxMemory(1<<20), zstd.WithDecoderConcurrency(0))
})

func inflate(frame []byte) ([]byte, error) {
	zstdDecoder, err := decoder()
	if err != nil {
		return nil, err
	}
	cells, err := zstdDecoder.DecodeAll(frame, make([]byte, 0, tileBytes))
	if err != nil || len(cells) != tileBytes {
		return nil, status.Error(codes.DataLoss, "a tile is damaged")
	}
	return cells, nil
}

func digestOf(text string) ([]byte, error) {
	digest, err := hex.DecodeString(text)
	if err != nil || len(digest) != 32 {
		return nil, status.Errorf(codes.InvalidArgument, "sha256: %q is not 64 hexadecimal digits", text)
	}
	return digest, nil
}

// readTiles calls take with each tile's digest and Zstandard frame, in the order of the request.
func (h *handlers) readTiles(ctx context.Context, site string, digests [][]byte, take func(digest, frame []byte) error) error {
	ctx, cancel := context.WithTimeout(ctx, callTime)
	defer cancel()
	stream, err := h.rasters.ReadTiles(ctx, &pb.ReadTilesRequest{Parent: site, Sha256: digests})
	if err != nil {
		return err
	}
	for {
		tile, err := stream.Recv()
		if err == io.EOF {
			return nil
		}
		if err != nil {
			return err
		}
		if err := take(tile.GetSha256(), tile.GetZstdCells()); err != nil {
			return err
		}
	}
}

// The frame of one tile, from the cache or the server.
func (h *handlers) frameOf(ctx context.Context, site, name string) ([]byte, error) {
	digest, err := digestOf(name)
	if err != nil {
		return nil, err
	}
	key := site + "/" + string(digest)
	if frame, ok := h.cache.get(key); ok {
		return frame, nil
	}
	var frame []byte
	err = h.readTiles(ctx, site, [][]byte{digest}, func(_, content []byte) error {
		frame = content
		return nil
	})
	if err == nil {
		h.cache.put(key, frame)
	}
	return frame, err
}

// accepts tells whether a client takes an encoding. Without "Accept-Encoding" it takes none.
func accepts(r *http.Request, encoding string) bool {
	for _, entry := range strings.Split(r.Header.Get("Accept-Encoding"), ",") {
		name, weight, _ := strings.Cut(strings.TrimSpace(entry), ";")
		if strings.TrimSpace(name) == encoding {
			weight = strings.ReplaceAll(weight, " ", "")
			return weight != "q=0" && weight != "q=0.0" && weight != "q=0.00" && weight != "q=0.000"
		}
	}
	return false
}

// One tile: 65,536 bytes, a cell each, row by row from the lowest. The stored frame itself for who takes zstd.
func (h *handlers) sendTile(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	frame, err := h.frameOf(contextOf(r), path["site"], path["sha256"])
	if err != nil {
		return err
	}
	if immutable(w, r, strings.ToLower(path["sha256"])) {
		return nil
	}
	header := w.Header()
	header.Set("Content-Type", "application/octet-stream")
	if accepts(r, "zstd") {
		header.Set("Content-Encoding", "zstd")
		return send(w, r, frame)
	}
	if !accepts(r, "gzip") {
		cells, err := inflate(frame)
		if err != nil {
			return err
		}
		return send(w, r, cells)
	}
	zipped, err := h.zipped(path["site"]+"/"+strings.ToLower(path["sha256"])+"/gzip", frame)
	if err != nil {
		return err
	}
	header.Set("Content-Encoding", "gzip")
	return send(w, r, zipped)
}

// A frame's content by gzip, from the cache if it is there.
func (h *handlers) zipped(key string, frame []byte) ([]byte, error) {
	if content, ok := h.cache.get(key); ok {
		return content, nil
	}
	cells, err := inflate(frame)
	if err != nil {
		return nil, err
	}
	var out bytes.Buffer
	writer := writers.Get().(*gzip.Writer)
	defer writers.Put(writer)
	writer.Reset(&out)
	_, _ = writer.Write(cells) // into memory
	_ = writer.Close()
	h.cache.put(key, out.Bytes())
	return out.Bytes(), nil
}

// sendCompressed sends content, by gzip to those who take it.
func sendCompressed(w http.ResponseWriter, r *http.Request, content []byte) error {
	if !accepts(r, "gzip") {
		return send(w, r, content)
	}
	w.Header().Set("Content-Encoding", "gzip")
	if r.Method == http.MethodHead {
		return nil
	}
	writer := writers.Get().(*gzip.Writer)
	defer writers.Put(writer)
	writer.Reset(w)
	if _, err := writer.Write(content); err != nil {
		return nil // the client is gone
	}
	_ = writer.Close()
	return nil
}

var writers = sync.Pool{New: func() any {
	writer, _ := gzip.NewWriterLevel(nil, gzip.BestSpeed)
	return writer
}}
