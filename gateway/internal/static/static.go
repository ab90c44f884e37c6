// SPDX-License-Identifier: Apache-2.0

// Package static serves files that are part of the program.
package static

import (
	"bytes"
	"crypto/sha256"
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

// Files by their names.
type Files map[string]file

type file struct {
	plain      []byte
	compressed []byte // by gzip
	mediaType  string
	tag        string
}

// Read all files that have a compressed form, NAME.gz, beside them.
func Read(folder fs.FS) (Files, error) {
	files := Files{}
	err := fs.WalkDir(folder, ".", func(name string, entry fs.DirEntry, err error) error {
		plainName, isCompressed := strings.CutSuffix(name, ".gz")
		if err != nil || !isCompressed {
			return err
		}
		compressed, err := fs.ReadFile(folder, name)
		if err != nil {
			return err
		}
		plain, err := fs.ReadFile(folder, plainName)
		if err != nil {
			return err
		}
		sum := sha256.Sum256(plain)
		files[plainName] = file{plain, compressed, mime.TypeByExtension(path.Ext(plainName)), `"` + hex.EncodeToString(sum[:16]) + `"`}
		return nil
	})
	return files, err
}

// IsRead tells whether a request reads; if not, it is answered here.
func IsRead(w http.ResponseWriter, r *http.Request) bool {
	if r.Method == http.MethodGet || r.Method == http.MethodHead {
		return true
	}
	w.Header().Set("Allow", "GET, HEAD")
	rest.WriteStatus(w, http.StatusMethodNotAllowed, codes.Unimplemented, "this page can only be read")
	return false
}

// Serve answers with a file: by gzip to those who take it.
func (f Files) Serve(w http.ResponseWriter, r *http.Request, name, cacheControl string) {
	found, ok := f[name]
	if !ok {
		rest.WriteStatus(w, http.StatusNotFound, codes.NotFound, "there is nothing at "+r.URL.Path)
		return
	}
	header := w.Header()
	header.Set("Cache-Control", cacheControl)
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
