// SPDX-License-Identifier: Apache-2.0

// Package dashboard serves the pages of client/dashboard, which are part of the program.
package dashboard

import (
	"bytes"
	"crypto/sha256"
	"embed"
	"encoding/hex"
	"io/fs"
	"mime"
	"net/http"
	"path"
	"strings"
	"time"

	"google.golang.org/grpc/codes"

	"enfilade/gateway/internal/rest"
)

//go:embed all:assets
var embedded embed.FS

const indexName = "index.html"

type file struct {
	plain      []byte
	compressed []byte // by gzip
	mediaType  string
	tag        string
}

// Handler answers every path that belongs to nothing else: with a file of the dashboard or, since its pages have addresses
// of their own, with its first page.
func Handler() (http.Handler, error) {
	assets, err := fs.Sub(embedded, "assets")
	if err != nil {
		return nil, err
	}
	files, err := read(assets)
	if err != nil {
		return nil, err
	}
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) { serve(w, r, files) }), nil
}

func read(assets fs.FS) (map[string]file, error) {
	files := map[string]file{}
	err := fs.WalkDir(assets, ".", func(name string, entry fs.DirEntry, err error) error {
		if err != nil || entry.IsDir() || strings.HasSuffix(name, ".gz") {
			return err
		}
		plain, err := fs.ReadFile(assets, name)
		if err != nil {
			return err
		}
		compressed, err := fs.ReadFile(assets, name+".gz")
		if err != nil {
			return err
		}
		sum := sha256.Sum256(plain)
		files[name] = file{plain, compressed, mime.TypeByExtension(path.Ext(name)), `"` + hex.EncodeToString(sum[:16]) + `"`}
		return nil
	})
	return files, err
}

func serve(w http.ResponseWriter, r *http.Request, files map[string]file) {
	if r.Method != http.MethodGet && r.Method != http.MethodHead {
		w.Header().Set("Allow", "GET, HEAD")
		rest.WriteStatus(w, http.StatusMethodNotAllowed, codes.Unimplemented, "the dashboard can only be read")
		return
	}
	name := strings.TrimPrefix(path.Clean(r.URL.Path), "/")
	found, ok := files[name]
	if !ok {
		if path.Ext(name) != "" {
			rest.WriteStatus(w, http.StatusNotFound, codes.NotFound, "there is nothing at "+r.URL.Path)
			return
		}
		name = indexName
		found = files[name]
	}
	header := w.Header()
	// The build names its files by their content; the first page names them.
	switch {
	case strings.HasPrefix(name, "assets/"):
		header.Set("Cache-Control", "public, max-age=31536000, immutable")
	case name == indexName:
		header.Set("Cache-Control", "no-cache")
	default: // the icon, which browsers ask for with each address
		header.Set("Cache-Control", "public, max-age=86400")
	}
	header.Set("Content-Type", found.mediaType)
	header.Set("Vary", "Accept-Encoding")
	content, tag := found.plain, found.tag
	if strings.Contains(r.Header.Get("Accept-Encoding"), "gzip") {
		header.Set("Content-Encoding", "gzip")
		content, tag = found.compressed, strings.TrimSuffix(found.tag, `"`)+`-gzip"`
	}
	header.Set("ETag", tag)
	// The tag decides, not a time. A part of a compressed file is of no use.
	r.Header.Del("Range")
	http.ServeContent(w, r, "", time.Time{}, bytes.NewReader(content))
}
