// SPDX-License-Identifier: Apache-2.0

package telemetry

import (
	"encoding/json"
	"net/http"
	"strings"
	"time"

	dto "github.com/prometheus/client_model/go"
)

// Status is what people want to know of a gateway, counted since it began.
type Status struct {
	UptimeS      float64 `json:"uptimeS"`
	OpenRequests int64   `json:"openRequests"` // streams included
	Requests     int64   `json:"requests"`     // that have ended
	ServerErrors int64   `json:"serverErrors"` // of these, answered with 5xx
	CutAnswers   int64   `json:"cutAnswers"`   // of these, not taken whole by the client
	SentBytes    int64   `json:"sentBytes"`    // of answers' bodies
}

// ServeStatus answers with the Status as JSON.
func (m *Metrics) ServeStatus(w http.ResponseWriter, _ *http.Request) {
	families, err := m.registry.Gather()
	if err != nil {
		http.Error(w, "the metrics cannot be read", http.StatusInternalServerError)
		return
	}
	status := Status{UptimeS: time.Since(m.begin).Seconds()}
	for _, family := range families {
		for _, metric := range family.GetMetric() {
			status.add(family.GetName(), metric)
		}
	}
	w.Header().Set("Content-Type", "application/json")
	w.Header().Set("Cache-Control", "no-store")
	_ = json.NewEncoder(w).Encode(status) // else the client is gone
}

func (s *Status) add(name string, metric *dto.Metric) {
	count := int64(metric.GetCounter().GetValue())
	switch name {
	case openRequests:
		s.OpenRequests += int64(metric.GetGauge().GetValue())
	case cutAnswers:
		s.CutAnswers += count
	case sentBytes:
		s.SentBytes += count
	case endedRequests:
		s.Requests += count
		for _, label := range metric.GetLabel() {
			if label.GetName() == "status" && strings.HasPrefix(label.GetValue(), "5") {
				s.ServerErrors += count
			}
		}
	}
}
