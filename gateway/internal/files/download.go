// SPDX-License-Identifier: Apache-2.0

// Package files serves what the API streams in chunks as plain files, and takes uploads as plain files.
package files

import (
	"context"
	"encoding/hex"
	"errors"
	"io"
	"log/slog"
	"mime"
	"net/http"
	"strconv"
	"strings"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	"enfilade/gateway/internal/rest"
)

// File is one that the server sends from its begin to its end.
type File struct {
	Name      string
	Size      int64
	SHA256    []byte
	MediaType string
	Immutable bool                   // its address names its content
	Inline    bool                   // may be shown by a browser
	Next      func() ([]byte, error) // the next piece; io.EOF behind the last
}

// byteRange of a file: [first, end).
type byteRange struct{ first, end int64 }

// Send answers with a file, a range of it, or with 304 if the client has it.
func Send(w http.ResponseWriter, r *http.Request, file *File) {
	header := w.Header()
	etag := `"` + hex.EncodeToString(file.SHA256) + `"`
	header.Set("ETag", etag)
	header.Set("Accept-Ranges", "bytes")
	if file.Immutable {
		header.Set("Cache-Control", "private, max-age=31536000, immutable")
	} else {
		header.Set("Cache-Control", "private, no-cache")
	}
	if matches(r.Header.Get("If-None-Match"), etag) {
		w.WriteHeader(http.StatusNotModified)
		return
	}
	disposition := "attachment"
	if file.Inline {
		disposition = "inline"
	}
	header.Set("Content-Type", file.MediaType)
	header.Set("Content-Disposition", mime.FormatMediaType(disposition, map[string]string{"filename": file.Name}))

	part, partial := byteRange{0, file.Size}, false
	if condition := r.Header.Get("If-Range"); condition == "" || condition == etag {
		var err error
		if part, partial, err = parseRange(r.Header.Get("Range"), file.Size); err != nil {
			header.Set("Content-Range", "bytes */"+strconv.FormatInt(file.Size, 10))
			header.Del("Content-Disposition")
			rest.WriteStatus(w, http.StatusRequestedRangeNotSatisfiable, codes.OutOfRange, err.Error())
			return
		}
	}
	header.Set("Content-Length", strconv.FormatInt(part.end-part.first, 10))
	if partial {
		header.Set("Content-Range", "bytes "+strconv.FormatInt(part.first, 10)+"-"+
			strconv.FormatInt(part.end-1, 10)+"/"+strconv.FormatInt(file.Size, 10))
		w.WriteHeader(http.StatusPartialContent)
	}
	if r.Method == http.MethodHead {
		return
	}
	if err := copyPart(w, file, part); err != nil {
		if !errors.Is(err, context.Canceled) {
			slog.Warn("a download was cut off", "path", r.URL.Path, "error", err.Error())
		}
		panic(http.ErrAbortHandler) // the client must not take what it has for the whole
	}
}

func copyPart(w io.Writer, file *File, part byteRange) error {
	for at := int64(0); at < part.end; {
		piece, err := file.Next()
		if err == io.EOF {
			return io.ErrUnexpectedEOF
		}
		if err != nil {
			return err
		}
		begin, end := at, at+int64(len(piece))
		at = end
		if end <= part.first {
			continue
		}
		from, to := max(begin, part.first)-begin, min(end, part.end)-begin
		if _, err := w.Write(piece[from:to]); err != nil {
			return err
		}
	}
	return nil
}

func matches(condition, etag string) bool {
	for _, candidate := range strings.Split(condition, ",") {
		candidate = strings.TrimPrefix(strings.TrimSpace(candidate), "W/")
		if candidate == etag || candidate == "*" {
			return true
		}
	}
	return false
}

var errRange = errors.New("the range is not within the file")

// parseRange reads one range; more than one counts as none, as RFC 9110, 14.2 allows.
func parseRange(text string, size int64) (byteRange, bool, error) {
	whole := byteRange{0, size}
	spec, found := strings.CutPrefix(text, "bytes=")
	if !found || strings.Contains(spec, ",") {
		return whole, false, nil
	}
	first, last, found := strings.Cut(strings.TrimSpace(spec), "-")
	if !found {
		return whole, false, nil
	}
	if first == "" { // the last n bytes
		count, err := strconv.ParseInt(last, 10, 64)
		if err != nil || count < 0 {
			return whole, false, nil
		}
		if count == 0 || size == 0 {
			return whole, false, errRange
		}
		return byteRange{max(0, size-count), size}, true, nil
	}
	begin, err := strconv.ParseInt(first, 10, 64)
	if err != nil || begin < 0 {
		return whole, false, nil
	}
	if begin >= size {
		return whole, false, errRange
	}
	end := size
	if last != "" {
		value, err := strconv.ParseInt(last, 10, 64)
		if err != nil || value < begin {
			return whole, false, nil
		}
		end = min(size, value+1)
	}
	return byteRange{begin, end}, true, nil
}

// errNoManifest: the server broke the protocol.
var errNoManifest = status.Error(codes.Internal, "the server sent no manifest")
