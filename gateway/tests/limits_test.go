// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"context"
	"encoding/json"
	"errors"
	"fmt"
	"io"
	"log/slog"
	"net"
	"net/http"
	"os"
	"strconv"
	"strings"
	"testing"
	"time"

	"enfilade/gateway/internal/app"
	"enfilade/gateway/internal/files"
	"enfilade/gateway/internal/guard"
)

// startGateway starts one more gateway, with other limits, before `server`; the test stops it. Returns its URL.
func startGateway(t *testing.T, server string, limits guard.Limits) string {
	options := app.Options{Server: server, CallTime: 30 * time.Second, Limits: limits, Uploads: files.DefaultUploadLimits()}
	return startGatewayOf(t, options, slog.DiscardHandler)
}

func startGatewayOf(t *testing.T, options app.Options, log slog.Handler) string {
	t.Helper()
	options.Listen, options.Hosts = "127.0.0.1:0", []string{"127.0.0.1"}
	gateway, err := app.Start(t.Context(), options, slog.New(log))
	if err != nil {
		t.Fatal(err)
	}
	t.Cleanup(func() {
		ctx, cancel := context.WithTimeout(context.Background(), 10*time.Second)
		defer cancel()
		_ = gateway.Stop(ctx)
	})
	return "http://" + gateway.Addr()
}

// clientAt is a client whose requests come from another address of this machine.
func clientAt(address string) *http.Client {
	dialer := net.Dialer{LocalAddr: &net.TCPAddr{IP: net.ParseIP(address)}}
	return &http.Client{Transport: &http.Transport{DialContext: dialer.DialContext}}
}

func statusOf(t *testing.T, client *http.Client, method, url string) (int, http.Header) {
	t.Helper()
	request, err := http.NewRequest(method, url, nil)
	if err != nil {
		t.Fatal(err)
	}
	response, err := client.Do(request)
	if err != nil {
		t.Fatal(err)
	}
	defer response.Body.Close()
	_, _ = io.Copy(io.Discard, response.Body)
	return response.StatusCode, response.Header
}

func TestSecurity_CallsBeyondTheRateWaitAndHarmNoOtherAddress(t *testing.T) {
	limits := guard.DefaultLimits()
	limits.Rates = guard.Rates{CallsPerSecond: 0.001, TilesPerSecond: 0.001} // a burst of one each
	url := startGateway(t, shared.address, limits)
	loud, other := clientAt("127.0.0.1"), clientAt("127.0.0.2")
	if status, _ := statusOf(t, loud, "GET", url+"/v1/sites"); status != http.StatusOK {
		t.Fatalf("the first call: status %d", status)
	}
	status, header := statusOf(t, loud, "GET", url+"/v1/sites")
	if status != http.StatusTooManyRequests {
		t.Errorf("the second call: status %d", status)
	}
	if wait, err := strconv.Atoi(header.Get("Retry-After")); err != nil || wait < 100 || wait > 1000 {
		t.Errorf("Retry-After %q", header.Get("Retry-After"))
	}
	tile := url + "/v1/sites/nowhere/tiles/" + strings.Repeat("0", 64)
	if status, _ := statusOf(t, loud, "GET", tile); status != http.StatusNotFound {
		t.Errorf("a tile counts as a call: status %d", status)
	}
	if status, _ := statusOf(t, loud, "GET", tile); status != http.StatusTooManyRequests {
		t.Errorf("the second tile: status %d", status)
	}
	if status, _ := statusOf(t, loud, "GET", url+"/openapi.json"); status != http.StatusOK {
		t.Errorf("a page: status %d", status)
	}
	if status, _ := statusOf(t, other, "GET", url+"/v1/sites"); status != http.StatusOK {
		t.Errorf("another address: status %d", status)
	}
}

func TestSecurity_SixHundredStreams(t *testing.T) {
	site := newSite(t)
	statuses := map[int]int{}
	for number := range 600 {
		client := clientAt(fmt.Sprintf("127.0.1.%d", 1+number/60))
		request, _ := http.NewRequestWithContext(t.Context(), "GET", shared.url+"/v1/"+site+"/globalPoses:watch", nil)
		request.Header.Set("Accept", "text/event-stream")
		response, err := client.Do(request)
		if err != nil {
			t.Fatal(err)
		}
		defer client.CloseIdleConnections()
		defer response.Body.Close()
		statuses[response.StatusCode]++
	}
	if statuses[http.StatusOK] != 500 || statuses[http.StatusTooManyRequests] != 100 {
		t.Errorf("statuses %v", statuses)
	}
	if got := call(t, "GET", "/v1/"+site, nil, nil); got.status != http.StatusOK {
		t.Errorf("a call while all streams are open: status %d", got.status)
	}
}

// A client asks again and again and reads nothing. Its connection is closed, with requests in it that nobody will read;
// then the client cannot write either.
func TestSecurity_AReaderThatTakesNothingIsCutOffAndOthersAreServed(t *testing.T) {
	limits := guard.DefaultLimits()
	limits.WriteTime = time.Second
	var log lockedBuffer
	url := startGatewayOf(t, app.Options{Server: shared.address, CallTime: 30 * time.Second, Limits: limits,
		Uploads: files.DefaultUploadLimits()}, slog.NewJSONHandler(&log, nil))
	connection, err := net.Dial("tcp", strings.TrimPrefix(url, "http://"))
	if err != nil {
		t.Fatal(err)
	}
	defer connection.Close()
	request := []byte("GET /openapi.json HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
	for err == nil {
		_ = connection.SetWriteDeadline(time.Now().Add(60 * time.Second))
		_, err = connection.Write(request)
		if status, _ := statusOf(t, http.DefaultClient, "GET", url+"/v1/sites"); status == http.StatusTooManyRequests {
			time.Sleep(100 * time.Millisecond)
		} else if status != http.StatusOK {
			t.Fatalf("another client: status %d", status)
		}
	}
	if errors.Is(err, os.ErrDeadlineExceeded) {
		t.Errorf("the connection is still open: %v", err)
	}
	if text := log.String(); !strings.Contains(text, `"cut":"write tcp`) || !strings.Contains(text, "i/o timeout") {
		t.Errorf("the log does not say that the answer was cut, or why: %s", text)
	}
}

func TestSecurity_NamesThatLookLikePagesOrScriptsAreText(t *testing.T) {
	site := newSite(t)
	for _, name := range []string{`<img src=x onerror=alert(1)>`, `javascript:alert(1)`, `</script><script>alert(1)</script>`} {
		got := must(t, "POST", "/v1/"+site+"/maps", `{"displayName": "`+name+`"}`)
		if made, _ := got["map"].(map[string]any); made["displayName"] != name {
			t.Errorf("%q came back as %v", name, got)
		}
		for _, path := range []string{"/v1/" + site + "/maps", "/v1/" + site + "/maps/" + "%3Cscript%3E", "/%3Cscript%3E.txt"} {
			answer := call(t, "GET", path, nil, nil)
			if media := answer.header.Get("Content-Type"); !strings.HasPrefix(media, "application/json") {
				t.Errorf("%s: media type %q", path, media)
			}
			if answer.header.Get("X-Content-Type-Options") != "nosniff" {
				t.Errorf("%s: a browser may guess the type", path)
			}
		}
	}
}

func TestStale_WithoutTheServerPagesLoadAndCallsSayWhenToTryAgain(t *testing.T) {
	url := startGateway(t, "unix:"+t.TempDir()+"/nobody.sock", guard.DefaultLimits())
	for path, wanted := range map[string]int{"/healthz": http.StatusOK, "/openapi.json": http.StatusOK,
		"/readyz": http.StatusServiceUnavailable, "/v1/sites": http.StatusServiceUnavailable,
		"/v1/sites/s/graph.geojson": http.StatusServiceUnavailable, "/v1/sites/s:watch": http.StatusServiceUnavailable} {
		status, header := statusOf(t, http.DefaultClient, "GET", url+path)
		if status != wanted {
			t.Errorf("%s: status %d", path, status)
		}
		if status == http.StatusServiceUnavailable && header.Get("Retry-After") == "" {
			t.Errorf("%s: no Retry-After", path)
		}
	}
	response, err := http.Get(url + "/v1/sites")
	if err != nil {
		t.Fatal(err)
	}
	defer response.Body.Close()
	if body, _ := io.ReadAll(response.Body); strings.Contains(string(body), "nobody.sock") ||
		!strings.Contains(string(body), "the map server cannot be reached") {
		t.Errorf("the answer: %s", body)
	}
}

func TestTheStatusCountsWhatThisGatewayAnswers(t *testing.T) {
	url := startGateway(t, "unix:"+t.TempDir()+"/nobody.sock", guard.DefaultLimits())
	for range 3 {
		statusOf(t, http.DefaultClient, "GET", url+"/healthz")
	}
	statusOf(t, http.DefaultClient, "GET", url+"/v1/sites")
	var status struct{ OpenRequests, Requests, ServerErrors, CutAnswers, SentBytes int64 }
	for deadline := time.Now().Add(10 * time.Second); status.Requests < 4 && time.Now().Before(deadline); {
		response, err := http.Get(url + "/statusz")
		if err != nil {
			t.Fatal(err)
		}
		err = json.NewDecoder(response.Body).Decode(&status)
		response.Body.Close()
		if err != nil {
			t.Fatal(err)
		}
	}
	if status.OpenRequests != 1 || status.ServerErrors != 1 || status.CutAnswers != 0 || status.SentBytes < 3*int64(len("ok\n")) {
		t.Errorf("status %+v", status)
	}
}

func TestAClientReadsItsOwnWrites(t *testing.T) {
	site := newSite(t)
	got := call(t, "POST", "/v1/"+site+":optimize", strings.NewReader("{}"), header{"Content-Type": "application/json"})
	version := got.header.Get("Enfilade-Graph-Version")
	if !strings.HasPrefix(version, site+"=") {
		t.Fatalf("status %d, version %q: %s", got.status, version, got.body)
	}
	got = call(t, "GET", "/v1/"+site+"/graph", nil, header{"Enfilade-Min-Graph-Version": version})
	if got.status != http.StatusOK {
		t.Errorf("status %d: %.200s", got.status, got.body)
	}
	got = call(t, "GET", "/v1/"+site+"/graph", nil, header{"Enfilade-Min-Graph-Version": site + "=999999"})
	if got.status != http.StatusServiceUnavailable {
		t.Errorf("a version that does not exist: status %d: %.200s", got.status, got.body)
	}
	got = call(t, "GET", "/v1/"+site+"/graph", nil, header{"Enfilade-Min-Graph-Version": "nonsense"})
	if got.status != http.StatusBadRequest {
		t.Errorf("no version: status %d: %.200s", got.status, got.body)
	}
}
