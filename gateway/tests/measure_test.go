// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"encoding/json"
	"fmt"
	"io"
	"net/http"
	"os"
	"runtime"
	"sort"
	"sync"
	"testing"
	"time"

	pb "enfilade/gateway/gen/enfilade/v1"
)

// TestMeasure is a benchmark (tests/bench/run ... bench_gateway): it writes figures as JSON to $ENFILADE_MEASURE.
func TestMeasure(t *testing.T) {
	path := os.Getenv("ENFILADE_MEASURE")
	if path == "" {
		t.Skip("ENFILADE_MEASURE names no file")
	}
	figures := map[string]any{"processors": runtime.NumCPU(), "unary": measureUnary(t), "tiles": measureTiles(t)}
	encoded, err := json.MarshalIndent(figures, "", " ")
	if err != nil {
		t.Fatal(err)
	}
	if err := os.WriteFile(path, append(encoded, '\n'), 0o644); err != nil {
		t.Fatal(err)
	}
}

func quantile(times []time.Duration, share float64) float64 {
	sort.Slice(times, func(i, j int) bool { return times[i] < times[j] })
	return float64(times[int(share*float64(len(times)-1))].Microseconds())
}

// The same call over gRPC and over REST, in turn, so that both meet the same load of the machine.
func measureUnary(t *testing.T) map[string]any {
	const calls = 4000
	sites := pb.NewSiteServiceClient(shared.direct)
	must(t, "POST", "/v1/sites?siteId=measured", `{"displayName": "Measured"}`)
	direct, rest := make([]time.Duration, 0, calls), make([]time.Duration, 0, calls)
	for i := range calls + 200 {
		begin := time.Now()
		if _, err := sites.GetSite(t.Context(), &pb.GetSiteRequest{Name: "sites/measured"}); err != nil {
			t.Fatal(err)
		}
		middle := time.Now()
		if got := call(t, "GET", "/v1/sites/measured", nil, nil); got.status != http.StatusOK {
			t.Fatalf("status %d", got.status)
		}
		if i >= 200 { // warm
			direct, rest = append(direct, middle.Sub(begin)), append(rest, time.Since(middle))
		}
	}
	grpc, http := quantile(direct, 0.5), quantile(rest, 0.5)
	return map[string]any{"calls": calls, "grpc_p50_us": grpc, "grpc_p99_us": quantile(direct, 0.99), "rest_p50_us": http,
		"rest_p99_us": quantile(rest, 0.99), "overhead_p50_us": http - grpc}
}

// Tiles as a browser fetches them: one after the other on each of its connections.
func measureTiles(t *testing.T) map[string]any {
	const clients, seconds = 6, 3
	site, _, manifest := withHall(t)
	var urls []string
	for _, level := range manifest.Levels {
		for _, tile := range level.Tiles {
			urls = append(urls, shared.url+"/v1/"+site+"/tiles/"+hexOf(t, tile.Sha256))
		}
	}
	figures := map[string]any{"tiles": len(urls), "clients": clients}
	for _, encoding := range []string{"zstd", "gzip", "identity"} {
		count, bytes := fetchFor(t, urls, encoding, clients, seconds*time.Second)
		figures[encoding+"_per_s"] = float64(count) / seconds
		figures[encoding+"_bytes_per_tile"] = float64(bytes) / float64(max(count, 1))
	}
	return figures
}

func fetchFor(t *testing.T, urls []string, encoding string, clients int, duration time.Duration) (int, int64) {
	transport := &http.Transport{MaxIdleConnsPerHost: clients, DisableCompression: true}
	defer transport.CloseIdleConnections()
	var group sync.WaitGroup
	counts, bytes := make([]int, clients), make([]int64, clients)
	until := time.Now().Add(duration)
	for client := range clients {
		group.Go(func() {
			for i := client; time.Now().Before(until); i++ {
				request, _ := http.NewRequest("GET", urls[i%len(urls)], nil)
				request.Header.Set("Accept-Encoding", encoding)
				response, err := transport.RoundTrip(request)
				if err != nil {
					t.Error(err)
					return
				}
				size, err := io.Copy(io.Discard, response.Body)
				response.Body.Close()
				if err != nil || response.StatusCode != http.StatusOK {
					t.Error(fmt.Errorf("status %d: %w", response.StatusCode, err))
					return
				}
				counts[client], bytes[client] = counts[client]+1, bytes[client]+size
			}
		})
	}
	group.Wait()
	total, size := 0, int64(0)
	for client := range clients {
		total, size = total+counts[client], size+bytes[client]
	}
	return total, size
}
