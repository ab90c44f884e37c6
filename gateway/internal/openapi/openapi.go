// SPDX-License-Identifier: Apache-2.0

// Package openapi serves the description of the REST API.
package openapi

import (
	"crypto/sha256"
	_ "embed"
	"encoding/hex"
	"net/http"
)

// Document is OpenAPI 3.0, made from the protos' comments and proto/gateway.yaml.
//
//go:embed openapi.json
var Document []byte

// Serve answers with the document.
func Serve(w http.ResponseWriter, r *http.Request) {
	digest := sha256.Sum256(Document)
	etag := `"` + hex.EncodeToString(digest[:]) + `"`
	w.Header().Set("ETag", etag)
	w.Header().Set("Cache-Control", "no-cache")
	if r.Header.Get("If-None-Match") == etag {
		w.WriteHeader(http.StatusNotModified)
		return
	}
	w.Header().Set("Content-Type", "application/json")
	_, _ = w.Write(Document)
}
