// SPDX-License-Identifier: Apache-2.0

// Package dashboard serves the pages of client/dashboard, which are part of the program.
package dashboard

import (
	"embed"
	"io/fs"
	"net/http"
	"path"
	"strings"

	"enfilade/gateway/internal/static"
)

//go:embed all:assets
var embedded embed.FS

const indexName = "index.html"

// Handler answers every path that belongs to nothing else: with a file of the dashboard or, since its pages have addresses
// of their own, with its first page.
func Handler() (http.Handler, error) {
	assets, err := fs.Sub(embedded, "assets")
	if err != nil {
		return nil, err
	}
	files, err := static.Read(assets)
	if err != nil {
		return nil, err
	}
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) { serve(w, r, files) }), nil
}

func serve(w http.ResponseWriter, r *http.Request, files static.Files) {
	if !static.IsRead(w, r) {
		return
	}
	name := strings.TrimPrefix(path.Clean(r.URL.Path), "/")
	if _, ok := files[name]; !ok && path.Ext(name) == "" {
		name = indexName
	}
	// The build names its files by their content; the first page names them.
	switch {
	case strings.HasPrefix(name, "assets/"):
		files.Serve(w, r, name, "public, max-age=31536000, immutable")
	case name == indexName:
		files.Serve(w, r, name, "no-cache")
	default: // the icon, which browsers ask for with each address
		files.Serve(w, r, name, "public, max-age=86400")
	}
}
