// SPDX-License-Identifier: Apache-2.0

// Package guard keeps from the API what a browser or a network may send but no client of ours does: requests of foreign
// sites, foreign hosts, bodies of other types or sizes, and more streams than one client needs.
package guard

import (
	"bytes"
	"errors"
	"io"
	"mime"
	"net"
	"net/http"
	"strings"
	"sync"
	"time"

	"google.golang.org/grpc/codes"

	"enfilade/gateway/internal/rest"
)

// Limits of what one client may ask for.
type Limits struct {
	BodyBytes        int64         // of a JSON body
	PlanBytes        int64         // of a JSON body with a whole floor plan
	Streams          int           // open at once, of all clients
	StreamsPerClient int           // of one address
	WriteTime        time.Duration // for the client to take what is written
	Rates            Rates
}

// DefaultLimits suit a campus' dashboards and programs.
func DefaultLimits() Limits {
	return Limits{BodyBytes: 1 << 20, PlanBytes: 32 << 20, Streams: 500, StreamsPerClient: 64, WriteTime: 10 * time.Second,
		Rates: DefaultRates()}
}

// The page may load nothing from elsewhere and run nothing but its own scripts.
const contentSecurityPolicy = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; " +
	"connect-src 'self'; worker-src 'self'; font-src 'self'; base-uri 'none'; form-action 'self'; " +
	"frame-ancestors 'none'"

// Wrap guards `next`. `hosts`: the names, without ports, by which clients may call the gateway. `origins`: of pages from
// elsewhere that may change things, such as https://maps.example.org.
func Wrap(next http.Handler, hosts, origins []string, limits Limits) (http.Handler, error) {
	protection := http.NewCrossOriginProtection()
	for _, origin := range origins {
		if err := protection.AddTrustedOrigin(origin); err != nil {
			return nil, err
		}
	}
	protection.SetDenyHandler(http.HandlerFunc(func(w http.ResponseWriter, _ *http.Request) {
		rest.WriteStatus(w, http.StatusForbidden, codes.PermissionDenied,
			"a page of another site may not do this: its origin is not among those that the gateway trusts")
	}))
	handler := limitStreams(next, limits)
	handler = checkBody(handler, limits)
	handler = limitRates(handler, limits.Rates)
	handler = protection.Handler(handler)
	handler = checkHost(handler, hosts)
	return addHeaders(handler, limits.WriteTime), nil
}

func addHeaders(next http.Handler, writeTime time.Duration) http.Handler {
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) {
		header := w.Header()
		header.Set("Content-Security-Policy", contentSecurityPolicy)
		header.Set("X-Content-Type-Options", "nosniff")
		header.Set("Referrer-Policy", "same-origin")
		header.Set("Cross-Origin-Opener-Policy", "same-origin")
		header.Set("Cross-Origin-Resource-Policy", "same-origin")
		if r.TLS != nil {
			header.Set("Strict-Transport-Security", "max-age=31536000")
		}
		next.ServeHTTP(&patientWriter{ResponseWriter: w, control: http.NewResponseController(w), time: writeTime}, r)
	})
}

// patientWriter gives the client a new deadline for each write: a stream may last as long as it is read.
type patientWriter struct {
	http.ResponseWriter
	control *http.ResponseController
	time    time.Duration
}

func (w *patientWriter) Write(content []byte) (int, error) {
	_ = w.control.SetWriteDeadline(time.Now().Add(w.time))
	return w.ResponseWriter.Write(content)
}

func (w *patientWriter) FlushError() error {
	_ = w.control.SetWriteDeadline(time.Now().Add(w.time))
	return w.control.Flush()
}

func (w *patientWriter) Unwrap() http.ResponseWriter { return w.ResponseWriter }

// A page whose name has been made to lead here (DNS rebinding) names its own host.
func checkHost(next http.Handler, hosts []string) http.Handler {
	allowed := map[string]bool{}
	for _, host := range hosts {
		allowed[strings.ToLower(host)] = true
	}
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) {
		host := r.Host
		if name, _, err := net.SplitHostPort(host); err == nil {
			host = name
		}
		if !allowed[strings.ToLower(strings.Trim(host, "[]"))] {
			rest.WriteStatus(w, http.StatusMisdirectedRequest, codes.PermissionDenied,
				"the gateway does not answer to this host name: name it by --host")
			return
		}
		next.ServeHTTP(w, r)
	})
}

// Bodies are JSON, but for uploads (multipart), which have limits of their own. A type that a page can post without
// asking first is not taken for JSON.
func checkBody(next http.Handler, limits Limits) http.Handler {
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) {
		limit := limits.BodyBytes
		if strings.Contains(r.URL.Path, "/priorMaps/") && strings.HasSuffix(r.URL.Path, ":edit") {
			limit = limits.PlanBytes
		}
		mediaType, _, _ := mime.ParseMediaType(r.Header.Get("Content-Type"))
		if r.ContentLength == 0 || mediaType == "multipart/form-data" {
			next.ServeHTTP(w, r)
			return
		}
		content, err := io.ReadAll(http.MaxBytesReader(w, r.Body, limit))
		var tooLarge *http.MaxBytesError
		switch {
		case errors.As(err, &tooLarge):
			rest.WriteStatus(w, http.StatusRequestEntityTooLarge, codes.InvalidArgument,
				"the body is larger than the gateway accepts")
			return
		case err != nil:
			rest.WriteStatus(w, http.StatusBadRequest, codes.InvalidArgument, "the body could not be read")
			return
		case len(content) > 0 && mediaType != "application/json":
			rest.WriteStatus(w, http.StatusUnsupportedMediaType, codes.InvalidArgument,
				"the body must be JSON: Content-Type: application/json")
			return
		}
		r.Body = io.NopCloser(bytes.NewReader(content))
		r.ContentLength = int64(len(content))
		next.ServeHTTP(w, r)
	})
}

// IsStream tells whether a request opens a stream that lasts.
func IsStream(r *http.Request) bool { return strings.HasSuffix(r.URL.Path, ":watch") }

type streamCounts struct {
	mutex    sync.Mutex
	all      int
	byClient map[string]int
}

func (c *streamCounts) take(client string, limits Limits) bool {
	c.mutex.Lock()
	defer c.mutex.Unlock()
	if c.all >= limits.Streams || c.byClient[client] >= limits.StreamsPerClient {
		return false
	}
	c.all++
	c.byClient[client]++
	return true
}

func (c *streamCounts) release(client string) {
	c.mutex.Lock()
	defer c.mutex.Unlock()
	c.all--
	if c.byClient[client]--; c.byClient[client] == 0 {
		delete(c.byClient, client)
	}
}

func limitStreams(next http.Handler, limits Limits) http.Handler {
	counts := &streamCounts{byClient: map[string]int{}}
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) {
		if !IsStream(r) {
			next.ServeHTTP(w, r)
			return
		}
		client := rest.CallerOf(r)
		if !counts.take(client, limits) {
			refuse(w, 5*time.Second, "too many streams are open: close some, or share one")
			return
		}
		defer counts.release(client)
		next.ServeHTTP(w, r)
	})
}
