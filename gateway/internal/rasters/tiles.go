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
	"enfilade/gateway/internal/answer"
	"enfilade/gateway/internal/rest"
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
	if frame, ok := h.cache.Get(key); ok {
		return frame, nil
	}
	var frame []byte
	err = h.readTiles(ctx, site, [][]byte{digest}, func(_, content []byte) error {
		frame = content
		return nil
	})
	if err == nil {
		h.cache.Put(key, frame)
	}
	return frame, err
}

// One tile: 65,536 bytes, a cell each, row by row from the lowest. The stored frame itself for who takes zstd.
func (h *handlers) sendTile(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	frame, err := h.frameOf(rest.ContextOf(r), path["site"], path["sha256"])
	if err != nil {
		return err
	}
	if answer.Immutable(w, r, strings.ToLower(path["sha256"])) {
		return nil
	}
	header := w.Header()
	header.Set("Content-Type", "application/octet-stream")
	if answer.Accepts(r, "zstd") {
		header.Set("Content-Encoding", "zstd")
		return answer.Send(w, r, frame)
	}
	if !answer.Accepts(r, "gzip") {
		cells, err := inflate(frame)
		if err != nil {
			return err
		}
		return answer.Send(w, r, cells)
	}
	zipped, err := h.zipped(path["site"]+"/"+strings.ToLower(path["sha256"])+"/gzip", frame)
	if err != nil {
		return err
	}
	header.Set("Content-Encoding", "gzip")
	return answer.Send(w, r, zipped)
}

// A frame's content by gzip, from the cache if it is there.
func (h *handlers) zipped(key string, frame []byte) ([]byte, error) {
	if content, ok := h.cache.Get(key); ok {
		return content, nil
	}
	cells, err := inflate(frame)
	if err != nil {
		return nil, err
	}
	var out bytes.Buffer
	writer := answer.Writers.Get().(*gzip.Writer)
	defer answer.Writers.Put(writer)
	writer.Reset(&out)
	_, _ = writer.Write(cells) // into memory
	_ = writer.Close()
	h.cache.Put(key, out.Bytes())
	return out.Bytes(), nil
}
