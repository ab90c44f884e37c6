// SPDX-License-Identifier: Apache-2.0

package guard

import (
	"net/http"
	"net/http/httptest"
	"testing"
)

// ask sends a GET from an address to `handler`.
func ask(handler http.Handler, path, address string) *httptest.ResponseRecorder {
	request := httptest.NewRequest("GET", path, nil)
	request.RemoteAddr = address + ":1"
	answer := httptest.NewRecorder()
	handler.ServeHTTP(answer, request)
	return answer
}

func TestAThirdExportWaitsUntilOneHasEnded(t *testing.T) {
	begun, release := make(chan struct{}), make(chan struct{})
	slow := http.HandlerFunc(func(_ http.ResponseWriter, _ *http.Request) {
		begun <- struct{}{}
		<-release
	})
	handler := limitRates(slow, Rates{Exports: 2})
	ended := make(chan int, 4)
	export := func(path, address string) { ended <- ask(handler, path, address).Code }
	go export("/v1/sites/s/graph.geojson", "192.0.2.1")
	go export("/v1/sites/s/maps/m:export", "192.0.2.1")
	<-begun
	<-begun
	third := ask(handler, "/v1/sites/s/maps/m/revisions/1/files/map.pgm", "192.0.2.1")
	if third.Code != http.StatusTooManyRequests || third.Header().Get("Retry-After") == "" {
		t.Errorf("status %d, Retry-After %q", third.Code, third.Header().Get("Retry-After"))
	}
	go export("/v1/sites/s/graph.geojson", "192.0.2.2") // of another address
	<-begun
	go export("/v1/sites/s/priorMaps/p/files/plan.geojson", "192.0.2.1") // is stored
	<-begun
	close(release)
	for range 4 {
		if status := <-ended; status != http.StatusOK {
			t.Errorf("status %d", status)
		}
	}
	go export("/v1/sites/s/graph.geojson", "192.0.2.1")
	<-begun
	if status := <-ended; status != http.StatusOK {
		t.Errorf("after the others: status %d", status)
	}
}

func TestClientsThatOweNothingAreForgotten(t *testing.T) {
	all := &clients{byName: map[string]*client{}}
	for number := range 2 * maxClients {
		all.take(string(rune('a'+number)), false)
	}
	if len(all.byName) > maxClients {
		t.Errorf("%d clients are remembered", len(all.byName))
	}
}
