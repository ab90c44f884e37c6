// SPDX-License-Identifier: Apache-2.0

// Package telemetry logs and counts requests.
package telemetry

import (
	"crypto/rand"
	"encoding/hex"
	"log/slog"
	"net/http"
	"strconv"
	"strings"
	"time"

	"github.com/prometheus/client_golang/prometheus"
	"github.com/prometheus/client_golang/prometheus/promhttp"

	"enfilade/gateway/internal/rest"
)

// Names of metrics.
const (
	endedRequests = "enfilade_gateway_requests_total"
	cutAnswers    = "enfilade_gateway_cut_answers_total"
	sentBytes     = "enfilade_gateway_sent_bytes_total"
	openRequests  = "enfilade_gateway_open_requests"
)

// Metrics of the gateway, in a registry of their own.
type Metrics struct {
	begin    time.Time
	registry *prometheus.Registry
	requests *prometheus.CounterVec
	time     *prometheus.HistogramVec
	cut      *prometheus.CounterVec
	sent     prometheus.Counter
	open     prometheus.Gauge
}

// NewMetrics returns metrics that nothing has counted yet.
func NewMetrics() *Metrics {
	m := &Metrics{
		begin:    time.Now(),
		registry: prometheus.NewRegistry(),
		requests: prometheus.NewCounterVec(prometheus.CounterOpts{
			Name: endedRequests, Help: "Requests that have ended, by method, kind and status."},
			[]string{"method", "kind", "status"}),
		time: prometheus.NewHistogramVec(prometheus.HistogramOpts{
			Name: "enfilade_gateway_request_seconds", Help: "Time of requests, from the head to the end of the answer.",
			Buckets: prometheus.ExponentialBuckets(0.0005, 4, 9)}, []string{"kind"}),
		cut: prometheus.NewCounterVec(prometheus.CounterOpts{
			Name: cutAnswers,
			Help: "Answers that did not reach the client whole: it went away, or took nothing for too long. By kind."},
			[]string{"kind"}),
		sent: prometheus.NewCounter(prometheus.CounterOpts{
			Name: sentBytes, Help: "Bytes of answers' bodies."}),
		open: prometheus.NewGauge(prometheus.GaugeOpts{
			Name: openRequests, Help: "Requests under way, streams included."}),
	}
	m.registry.MustRegister(m.requests, m.time, m.cut, m.sent, m.open)
	m.cut.WithLabelValues("watch") // is there before the first one is cut, for rates
	return m
}

// Handler serves the metrics to Prometheus.
func (m *Metrics) Handler() http.Handler {
	return promhttp.HandlerFor(m.registry, promhttp.HandlerOpts{})
}

// kindOf a request, of which there are few: what comes behind the colon, or the collection.
func kindOf(path string) string {
	if _, verb, found := strings.Cut(path, ":"); found && !strings.Contains(verb, "/") && len(verb) <= 20 {
		return verb
	}
	if strings.HasPrefix(path, "/v1/") {
		return "resource"
	}
	return "page"
}

// Observe logs each request as one line of JSON, without its body, and counts it. A request without an id gets one.
func (m *Metrics) Observe(next http.Handler, log *slog.Logger) http.Handler {
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) {
		begin := time.Now()
		id := r.Header.Get("X-Request-Id")
		if id == "" || len(id) > 128 {
			random := make([]byte, 16)
			_, _ = rand.Read(random)
			id = hex.EncodeToString(random)
			r.Header.Set("X-Request-Id", id)
		}
		w.Header().Set("X-Request-Id", id)
		observed := &writer{ResponseWriter: w, status: http.StatusOK}
		m.open.Inc()
		defer func() {
			m.open.Dec()
			took := time.Since(begin)
			kind := kindOf(r.URL.Path)
			m.requests.WithLabelValues(r.Method, kind, strconv.Itoa(observed.status)).Inc()
			m.time.WithLabelValues(kind).Observe(took.Seconds())
			m.sent.Add(float64(observed.bytes))
			attributes := []any{"method", r.Method, "path", r.URL.Path, "status", observed.status, "bytes",
				observed.bytes, "duration_ms", float64(took.Microseconds()) / 1000, "request_id", id, "remote", r.RemoteAddr,
				"caller", rest.CallerOf(r)}
			if observed.cut != nil {
				m.cut.WithLabelValues(kind).Inc()
				attributes = append(attributes, "cut", observed.cut.Error())
			}
			log.Info("request", attributes...)
		}()
		next.ServeHTTP(observed, r)
	})
}

type writer struct {
	http.ResponseWriter
	status int
	bytes  int64
	cut    error // why the answer did not reach the client whole: the first write that failed
}

func (w *writer) WriteHeader(status int) {
	w.status = status
	w.ResponseWriter.WriteHeader(status)
}

func (w *writer) Write(content []byte) (int, error) {
	count, err := w.ResponseWriter.Write(content)
	w.bytes += int64(count)
	return count, w.note(err)
}

func (w *writer) FlushError() error {
	return w.note(http.NewResponseController(w.ResponseWriter).Flush())
}

func (w *writer) note(err error) error {
	if w.cut == nil {
		w.cut = err
	}
	return err
}

func (w *writer) Unwrap() http.ResponseWriter { return w.ResponseWriter }
