// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"compress/gzip"
	"io"
	"net/http"
	"regexp"
	"strings"
	"testing"
)

func TestThePagesOfTheDashboardArePartOfTheGateway(t *testing.T) {
	first := call(t, "GET", "/", nil, nil)
	if first.status != http.StatusOK || !strings.Contains(string(first.body), `<div id="root">`) {
		t.Fatalf("status %d: %.300s", first.status, first.body)
	}
	if control := first.header.Get("Cache-Control"); control != "no-cache" {
		t.Errorf("the first page may be kept: %q", control)
	}
	scripts := regexp.MustCompile(`src="(/assets/[^"]+\.js)"`).FindSubmatch(first.body)
	if scripts == nil {
		t.Fatalf("the first page names no script: %s", first.body)
	}
	script := string(scripts[1])
	got := call(t, "GET", script, nil, header{"Accept-Encoding": "identity"})
	if got.status != http.StatusOK || !strings.HasPrefix(got.header.Get("Content-Type"), "text/javascript") {
		t.Fatalf("%s: status %d, %s", script, got.status, got.header.Get("Content-Type"))
	}
	if control := got.header.Get("Cache-Control"); !strings.Contains(control, "immutable") {
		t.Errorf("%s: Cache-Control %q", script, control)
	}
	packed := call(t, "GET", script, nil, header{"Accept-Encoding": "gzip"})
	reader, err := gzip.NewReader(strings.NewReader(string(packed.body)))
	if err != nil {
		t.Fatal(err)
	}
	if unpacked, err := io.ReadAll(reader); err != nil || string(unpacked) != string(got.body) {
		t.Errorf("%s differs when it is compressed: %v", script, err)
	}
	for _, tag := range []string{got.header.Get("ETag"), packed.header.Get("ETag")} {
		encoding := map[bool]string{true: "gzip", false: "identity"}[strings.Contains(tag, "gzip")]
		again := call(t, "GET", script, nil, header{"If-None-Match": tag, "Accept-Encoding": encoding})
		if again.status != http.StatusNotModified {
			t.Errorf("%s with %s: status %d", script, tag, again.status)
		}
	}
}

func TestAddressesOfPagesLeadToTheDashboardAndOthersToNothing(t *testing.T) {
	for path, status := range map[string]int{
		"/s/demo/campus?l=0":  http.StatusOK,
		"/s/demo/robots/r1":   http.StatusOK,
		"/assets/nothing.js":  http.StatusNotFound,
		"/favicon.ico":        http.StatusNotFound,
		"/v1/nothing":         http.StatusNotFound,
		"/v1/sites/a/b/c/d/e": http.StatusNotFound,
	} {
		got := call(t, "GET", path, nil, nil)
		if got.status != status {
			t.Errorf("%s: status %d, wanted %d", path, got.status, status)
		}
		if status == http.StatusNotFound && !strings.HasPrefix(got.header.Get("Content-Type"), "application/json") {
			t.Errorf("%s: %s", path, got.header.Get("Content-Type"))
		}
	}
	if got := call(t, "POST", "/s/demo/campus", strings.NewReader("{}"), header{"Content-Type": "application/json"}); got.status != http.StatusMethodNotAllowed {
		t.Errorf("POST to a page: status %d", got.status)
	}
}
