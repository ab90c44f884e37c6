// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"bytes"
	"net"
	"net/http"
	"strings"
	"testing"
	"time"
)

func TestSecurity_WhatNoClientOfOursSendsIsRefused(t *testing.T) {
	site := newSite(t)
	optimize := "/v1/" + site + ":optimize"
	for _, c := range []struct {
		name, method, path, body string
		headers                  header
		status                   int
	}{
		{"text", "POST", optimize, "{}", header{"Content-Type": "text/plain"}, http.StatusUnsupportedMediaType},
		{"form", "POST", optimize, "site=x", header{"Content-Type": "application/x-www-form-urlencoded"},
			http.StatusUnsupportedMediaType},
		{"foreign page", "POST", optimize, "{}", header{"Content-Type": "application/json", "Sec-Fetch-Site": "cross-site",
			"Origin": "https://evil.example"}, http.StatusForbidden},
		{"foreign origin", "POST", optimize, "{}", header{"Content-Type": "application/json",
			"Origin": "https://evil.example"}, http.StatusForbidden},
		{"foreign host", "GET", "/v1/sites", "", header{"Host": "evil.example"}, http.StatusMisdirectedRequest},
		{"disguised delete", "POST", "/v1/" + site, "", header{"X-HTTP-Method-Override": "DELETE"},
			http.StatusMethodNotAllowed},
		{"too large", "POST", optimize, `{"site": "` + strings.Repeat("x", 2<<20) + `"}`,
			header{"Content-Type": "application/json"}, http.StatusRequestEntityTooLarge},
		{"a plan of usual size", "POST", "/v1/" + site + "/priorMaps/none:edit", `{"plan": "` + strings.Repeat("x", 2<<20) + `"}`,
			header{"Content-Type": "application/json"}, http.StatusNotFound},
		{"too large a plan", "POST", "/v1/" + site + "/priorMaps/none:edit", `{"plan": "` + strings.Repeat("x", 33<<20) + `"}`,
			header{"Content-Type": "application/json"}, http.StatusRequestEntityTooLarge},
		{"many parts", "POST", "/v1/" + site + "/linkPoints:find", `{"polygonWorld": {"points": [` +
			strings.TrimSuffix(strings.Repeat(`{},`, 100_000), ",") + `]}}`,
			header{"Content-Type": "application/json"}, http.StatusBadRequest},
		{"deep", "POST", optimize, `{"site": ` + strings.Repeat("[", 100_000) + strings.Repeat("]", 100_000) + `}`,
			header{"Content-Type": "application/json"}, http.StatusBadRequest},
		{"large head", "GET", "/v1/sites", "", header{"X-Large": strings.Repeat("x", 32<<10)},
			http.StatusRequestHeaderFieldsTooLarge},
		{"a change by GET", "GET", optimize, "", nil, http.StatusBadRequest}, // a site's name with a colon
	} {
		got := call(t, c.method, c.path, strings.NewReader(c.body), c.headers)
		if got.status != c.status {
			t.Errorf("%s: status %d (wanted %d): %.200s", c.name, got.status, c.status, got.body)
		}
		if got.status == http.StatusRequestHeaderFieldsTooLarge {
			continue // answered before anything has been read
		}
		if policy := got.header.Get("Content-Security-Policy"); !strings.Contains(policy, "default-src 'none'") {
			t.Errorf("%s: no policy: %q", c.name, policy)
		}
	}
	if got := call(t, "POST", optimize, nil, nil); got.status != http.StatusOK {
		t.Errorf("a POST without a body: status %d: %s", got.status, got.body)
	}
}

func TestSecurity_ASlowHeadIsCutOff(t *testing.T) {
	connection, err := net.Dial("tcp", shared.gateway.Addr())
	if err != nil {
		t.Fatal(err)
	}
	defer connection.Close()
	if _, err := connection.Write([]byte("GET /v1/sites HTTP/1.1\r\nHost: localhost\r\nX-Slow: ")); err != nil {
		t.Fatal(err)
	}
	_ = connection.SetReadDeadline(time.Now().Add(30 * time.Second))
	var rest bytes.Buffer
	if _, err := rest.ReadFrom(connection); err != nil {
		t.Fatalf("the connection is still open: %v", err)
	}
}

func TestSecurity_StreamsAreLimited(t *testing.T) {
	site := newSite(t)
	const streams = 70 // of one client; 64 are allowed
	statuses := map[int]int{}
	var open []*http.Response
	for range streams {
		request, _ := http.NewRequest("GET", shared.url+"/v1/"+site+"/globalPoses:watch", nil)
		request.Header.Set("Accept", "text/event-stream")
		client := http.Client{Transport: &http.Transport{}}
		response, err := client.Do(request)
		if err != nil {
			t.Fatal(err)
		}
		statuses[response.StatusCode]++
		open = append(open, response)
	}
	for _, response := range open {
		response.Body.Close()
	}
	if statuses[http.StatusOK] != 64 || statuses[http.StatusTooManyRequests] != streams-64 {
		t.Errorf("statuses %v", statuses)
	}
}

func TestSecurity_EveryAnswerTellsTheBrowserToTrustNothingElse(t *testing.T) {
	site := newSite(t)
	for _, path := range []string{"/", "/docs", "/openapi.json", "/healthz", "/readyz", "/statusz", "/v1/sites",
		"/v1/" + site + "/overview",
		"/v1/" + site + "/graph.geojson", "/v1/" + site + "/composite.png", "/v1/sites/nowhere", "/nothing"} {
		got := call(t, "GET", path, nil, header{"Sec-Fetch-Site": "cross-site", "Origin": "https://evil.example"})
		for name, wanted := range map[string]string{"X-Content-Type-Options": "nosniff", "Referrer-Policy": "same-origin",
			"Cross-Origin-Opener-Policy": "same-origin", "Cross-Origin-Resource-Policy": "same-origin",
			"Access-Control-Allow-Origin": ""} {
			if found := got.header.Get(name); found != wanted {
				t.Errorf("%s: %s is %q, wanted %q", path, name, found, wanted)
			}
		}
		policy := got.header.Get("Content-Security-Policy")
		for _, part := range []string{"default-src 'none'", "script-src 'self'", "frame-ancestors 'none'", "base-uri 'none'"} {
			if !strings.Contains(policy, part) {
				t.Errorf("%s: %q is not in the policy %q", path, part, policy)
			}
		}
	}
	preflight := call(t, "OPTIONS", "/v1/"+site+":optimize", nil, header{"Origin": "https://evil.example",
		"Access-Control-Request-Method": "POST", "Access-Control-Request-Headers": "content-type"})
	for name := range preflight.header {
		if strings.HasPrefix(name, "Access-Control-") {
			t.Errorf("a page of another origin is let in: %s", name)
		}
	}
}
