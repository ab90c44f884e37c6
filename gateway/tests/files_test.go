// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"bytes"
	"crypto/sha256"
	"encoding/hex"
	"fmt"
	"image"
	"image/png"
	"io"
	"mime/multipart"
	"net/http"
	"strings"
	"testing"
)

// A grid of `side` cells a side, as a PGM, with a line of walls.
func picture(side int) []byte {
	var out bytes.Buffer
	fmt.Fprintf(&out, "P5\n%d %d\n255\n", side, side)
	row := bytes.Repeat([]byte{254}, side)
	row[side/3] = 0
	for range side {
		out.Write(row)
	}
	return out.Bytes()
}

const description = "image: hall.pgm\nresolution: 0.05\norigin: [-1.0, -2.0, 0.0]\nnegate: 0\n" +
	"occupied_thresh: 0.65\nfree_thresh: 0.196\n"

func upload(t *testing.T, path string, fields map[string]string, files map[string][]byte) answer {
	t.Helper()
	var body bytes.Buffer
	form := multipart.NewWriter(&body)
	for name, value := range fields {
		_ = form.WriteField(name, value)
	}
	for name, content := range files {
		part, err := form.CreateFormFile("file", name)
		if err != nil {
			t.Fatal(err)
		}
		_, _ = part.Write(content)
	}
	_ = form.Close()
	return call(t, "POST", path, &body, header{"Content-Type": form.FormDataContentType()})
}

func TestFiles_AMapGoesUpAndComesDownUnchanged(t *testing.T) {
	site := newSite(t)
	image := picture(1500)
	got := upload(t, "/v1/"+site+"/maps/hall:import", map[string]string{"dialect": "nav2"},
		map[string][]byte{"hall.pgm": image, "hall.yaml": []byte(description)})
	if got.status != http.StatusOK {
		t.Fatalf("status %d: %s", got.status, got.body)
	}
	listed := must(t, "GET", "/v1/"+site+"/maps/hall/files", "")
	paths := map[string]string{}
	for _, file := range listed["files"].([]any) {
		entry := file.(map[string]any)
		paths[entry["name"].(string)] = entry["path"].(string)
		file := call(t, "GET", entry["path"].(string), nil, nil)
		digest := sha256.Sum256(file.body)
		if hex.EncodeToString(digest[:]) != entry["sha256"] || fmt.Sprint(len(file.body)) != entry["sizeBytes"] {
			t.Errorf("%v: %d bytes, status %d", entry, len(file.body), file.status)
		}
		if disposition := file.header.Get("Content-Disposition"); !strings.Contains(disposition, entry["name"].(string)) {
			t.Errorf("disposition %q", disposition)
		}
	}
	path := paths["Hall.pgm"]
	whole := call(t, "GET", path, nil, nil)
	if !bytes.Equal(whole.body, image) {
		t.Errorf("%d bytes of %d came back", len(whole.body), len(image))
	}
	etag := whole.header.Get("ETag")
	if cached := call(t, "GET", path, nil, header{"If-None-Match": etag}); cached.status != http.StatusNotModified {
		t.Errorf("cached: status %d", cached.status)
	}
	for _, c := range []struct {
		spec        string
		first, last int
	}{{"bytes=0-9", 0, 9}, {"bytes=1100000-1100099", 1100000, 1100099}, {"bytes=-7", len(image) - 7, len(image) - 1},
		{"bytes=2250000-", 2250000, len(image) - 1}} {
		part := call(t, "GET", path, nil, header{"Range": c.spec, "If-Range": etag})
		if part.status != http.StatusPartialContent || !bytes.Equal(part.body, image[c.first:c.last+1]) {
			t.Errorf("%s: status %d, %d bytes", c.spec, part.status, len(part.body))
		}
	}
	if beyond := call(t, "GET", path, nil, header{"Range": "bytes=99999999-"}); beyond.status != http.StatusRequestedRangeNotSatisfiable {
		t.Errorf("beyond: status %d", beyond.status)
	}
	head := call(t, "HEAD", path, nil, nil)
	if head.header.Get("Content-Length") != fmt.Sprint(len(image)) || len(head.body) != 0 {
		t.Errorf("HEAD: %v", head.header)
	}
	alias := "/v1/" + site + "/maps/hall/aliases/stable"
	must(t, "PATCH", alias, `{"revision": "`+listed["revision"].(string)+`"}`)
	if stable := call(t, "GET", alias+"/files/Hall.pgm", nil, nil); !bytes.Equal(stable.body, image) {
		t.Errorf("by its alias: status %d, %d bytes", stable.status, len(stable.body))
	}
	if graph := call(t, "GET", "/v1/"+site+"/graph.geojson", nil, nil); graph.json(t)["type"] != "FeatureCollection" {
		t.Errorf("graph: %s", graph.body)
	}
}

const largeSide = 14_200 // cells: 202 MB

// A download that breaks off in the middle goes on where it was.
func TestFiles_AMapOf200MegabytesComesDownInParts(t *testing.T) {
	site := newSite(t)
	image := picture(largeSide)
	got := upload(t, "/v1/"+site+"/maps/hall:import", nil, map[string][]byte{"hall.pgm": image, "hall.yaml": []byte(description)})
	if got.status != http.StatusOK {
		t.Fatalf("status %d: %s", got.status, got.body)
	}
	path := "/v1/" + site + "/maps/hall/revisions/1/files/Hall.pgm"
	first, err := http.Get(shared.url + path)
	if err != nil {
		t.Fatal(err)
	}
	if disposition := first.Header.Get("Content-Disposition"); disposition != "attachment; filename=Hall.pgm" {
		t.Errorf("disposition %q", disposition)
	}
	digest, broken := sha256.New(), int64(len(image)/2)
	if _, err := io.CopyN(digest, first.Body, broken); err != nil {
		t.Fatal(err)
	}
	first.Body.Close()
	etag := first.Header.Get("ETag")
	rest := call(t, "GET", path, nil, header{"Range": fmt.Sprintf("bytes=%d-", broken), "If-Range": etag})
	if wanted := fmt.Sprintf("bytes %d-%d/%d", broken, len(image)-1, len(image)); rest.status != http.StatusPartialContent ||
		rest.header.Get("Content-Range") != wanted {
		t.Fatalf("status %d, Content-Range %q, wanted %q", rest.status, rest.header.Get("Content-Range"), wanted)
	}
	digest.Write(rest.body)
	if wanted := sha256.Sum256(image); !bytes.Equal(digest.Sum(nil), wanted[:]) || etag != `"`+hex.EncodeToString(wanted[:])+`"` {
		t.Errorf("another file came down: SHA-256 %x, ETag %s", digest.Sum(nil), etag)
	}
	if again := call(t, "GET", path, nil, header{"If-None-Match": etag}); again.status != http.StatusNotModified || len(again.body) > 0 {
		t.Errorf("status %d, %d bytes", again.status, len(again.body))
	}
}

func TestFiles_AnUploadThatIsCutOffStoresNothing(t *testing.T) {
	site := newSite(t)
	reader, writer := io.Pipe()
	form := multipart.NewWriter(writer)
	go func() {
		part, _ := form.CreateFormFile("file", "hall.yaml")
		_, _ = io.WriteString(part, description)
		part, _ = form.CreateFormFile("file", "hall.pgm")
		image := picture(largeSide)
		_, _ = part.Write(image[:len(image)/2])
		_ = writer.CloseWithError(io.ErrUnexpectedEOF)
	}()
	request, _ := http.NewRequest("POST", shared.url+"/v1/"+site+"/maps/hall:import", reader)
	request.Header.Set("Content-Type", form.FormDataContentType())
	if response, err := http.DefaultTransport.RoundTrip(request); err == nil {
		response.Body.Close()
		t.Errorf("status %d", response.StatusCode)
	}
	if revisions := must(t, "GET", "/v1/"+site+"/maps/hall/revisions", "")["revisions"].([]any); len(revisions) > 0 {
		t.Errorf("revisions %v", revisions)
	}
	refused := upload(t, "/v1/"+site+"/maps/hall:import", nil, map[string][]byte{"hall.pgm": picture(10)})
	if refused.status != http.StatusBadRequest {
		t.Errorf("an image without its YAML: status %d: %s", refused.status, refused.body)
	}
}

// attach sends `content` as an image of a link point, and returns the address of the blob that it becomes.
func attach(t *testing.T, site, linkPoint, encoding string, content []byte) string {
	t.Helper()
	evidence := fmt.Sprintf(`{"map": "%s/maps/hall", "image": {"time": "2026-01-02T03:04:05Z", "camera": "CAMERA_FRONT", "encoding": %q}}`, site, encoding)
	got := upload(t, "/v1/"+linkPoint+"/evidence", map[string]string{"evidence": evidence}, map[string][]byte{"door.bin": content})
	if got.status != http.StatusOK {
		t.Fatalf("status %d: %s", got.status, got.body)
	}
	return fmt.Sprintf("/v1/%s/blobs/%x", site, sha256.Sum256(content))
}

func withDoor(t *testing.T) (site, linkPoint string) {
	t.Helper()
	site = newSite(t)
	must(t, "POST", "/v1/"+site+"/linkPoints?linkPointId=door", `{"kind": "KIND_DOOR", "anchors": [
		{"map": "`+site+`/maps/hall", "poseMapPlace": {"pose": {"x": 1}}}]}`)
	return site, site + "/linkPoints/door"
}

func TestFiles_AnImageBecomesEvidenceAndComesDownUnchanged(t *testing.T) {
	site, door := withDoor(t)
	var content bytes.Buffer
	if err := png.Encode(&content, image.NewGray(image.Rect(0, 0, 64, 48))); err != nil {
		t.Fatal(err)
	}
	got := call(t, "GET", attach(t, site, door, "ENCODING_PNG", content.Bytes()), nil, nil)
	if got.status != http.StatusOK || !bytes.Equal(got.body, content.Bytes()) || got.header.Get("Content-Type") != "image/png" {
		t.Errorf("status %d, %s, %d bytes of %d", got.status, got.header.Get("Content-Type"), len(got.body), content.Len())
	}
	if control := got.header.Get("Cache-Control"); !strings.Contains(control, "immutable") {
		t.Errorf("Cache-Control %q", control)
	}
}
