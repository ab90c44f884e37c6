// SPDX-License-Identifier: Apache-2.0

// Package reference serves the OpenAPI document as pages for people, by Swagger UI (gateway/reference).
package reference

import (
	"embed"
	"io/fs"
	"net/http"
	"strings"

	"enfilade/gateway/internal/static"
)

//go:embed all:assets
var embedded embed.FS

// Path is where Handler belongs, and all below it.
const Path = "/docs"

// Handler answers with the page and with the files that it names.
func Handler() (http.Handler, error) {
	assets, err := fs.Sub(embedded, "assets")
	if err != nil {
		return nil, err
	}
	files, err := static.Read(assets)
	if err != nil {
		return nil, err
	}
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) {
		if !static.IsRead(w, r) {
			return
		}
		name := strings.Trim(strings.TrimPrefix(r.URL.Path, Path), "/")
		if name == "" {
			name = "index.html"
		}
		files.Serve(w, r, name, "no-cache")
	}), nil
}
