// SPDX-License-Identifier: Apache-2.0

// Package answer sends content with the headers that caches and compression need.
package answer

import (
	"compress/gzip"
	"net/http"
	"strconv"
	"strings"
	"sync"
)

// Send content; a client that is gone is no error.
func Send(w http.ResponseWriter, r *http.Request, content []byte) error {
	w.Header().Set("Content-Length", strconv.Itoa(len(content)))
	if r.Method != http.MethodHead {
		_, _ = w.Write(content) // else the client is gone
	}
	return nil
}

// Has sets the ETag, and answers 304 if the client has it. The tag is weak: the content comes in several encodings.
func Has(w http.ResponseWriter, r *http.Request, tag string) bool {
	header := w.Header()
	header.Set("ETag", `W/"`+tag+`"`)
	header.Set("Vary", "Accept-Encoding")
	for _, candidate := range strings.Split(r.Header.Get("If-None-Match"), ",") {
		candidate = strings.TrimPrefix(strings.TrimSpace(candidate), "W/")
		if candidate == `"`+tag+`"` || candidate == "*" {
			w.WriteHeader(http.StatusNotModified)
			return true
		}
	}
	return false
}

// Immutable does the same for an address that names its content.
func Immutable(w http.ResponseWriter, r *http.Request, tag string) bool {
	w.Header().Set("Cache-Control", "private, max-age=31536000, immutable")
	return Has(w, r, tag)
}

// Accepts tells whether a client takes an encoding. Without "Accept-Encoding" it takes none.
func Accepts(r *http.Request, encoding string) bool {
	for _, entry := range strings.Split(r.Header.Get("Accept-Encoding"), ",") {
		name, weight, _ := strings.Cut(strings.TrimSpace(entry), ";")
		if strings.TrimSpace(name) == encoding {
			weight = strings.ReplaceAll(weight, " ", "")
			return weight != "q=0" && weight != "q=0.0" && weight != "q=0.00" && weight != "q=0.000"
		}
	}
	return false
}

// SendCompressed sends content, by gzip to those who take it.
func SendCompressed(w http.ResponseWriter, r *http.Request, content []byte) error {
	if !Accepts(r, "gzip") {
		return Send(w, r, content)
	}
	w.Header().Set("Content-Encoding", "gzip")
	if r.Method == http.MethodHead {
		return nil
	}
	writer := Writers.Get().(*gzip.Writer)
	defer Writers.Put(writer)
	writer.Reset(w)
	if _, err := writer.Write(content); err != nil {
		return nil // the client is gone
	}
	_ = writer.Close()
	return nil
}

// Writers of gzip, to be reset.
var Writers = sync.Pool{New: func() any {
	writer, _ := gzip.NewWriterLevel(nil, gzip.BestSpeed)
	return writer
}}
