// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"bytes"
	"compress/gzip"
	"encoding/base64"
	"encoding/binary"
	"encoding/hex"
	"encoding/json"
	"fmt"
	"image/png"
	"io"
	"net/http"
	"strings"
	"testing"

	"github.com/klauspost/compress/zstd"
)

type tileManifest struct {
	Revision     string
	Classes      string
	DisplayOnly  bool
	FirstColumn  int
	Width        int
	Height       int
	PoseMapTiles struct{ X, Y float64 }
	Levels       []struct {
		Zoom  int
		Tiles []struct {
			Row, Column int
			Sha256      string
		}
	}
}

// importHall into a map: 30 m x 15 m with a wall in one column.
func importHall(t *testing.T, site, id string, wall int) {
	t.Helper()
	const width, height = 600, 300
	pixels := bytes.Repeat([]byte{254}, width*height)
	for row := range height {
		pixels[row*width+wall] = 0
	}
	image := append(fmt.Appendf(nil, "P5\n%d %d\n255\n", width, height), pixels...)
	text := strings.Replace(description, "[-1.0, -2.0, 0.0]", "[0, 0, 0]", 1)
	imported := upload(t, "/v1/"+site+"/maps/"+id+":import", map[string]string{"dialect": "nav2"},
		map[string][]byte{"hall.pgm": image, "hall.yaml": []byte(text)})
	if imported.status != http.StatusOK {
		t.Fatalf("status %d: %s", imported.status, imported.body)
	}
}

// withHall imports a map with a wall in column 3 and returns its manifest and its site.
func withHall(t *testing.T) (string, answer, tileManifest) {
	t.Helper()
	site := newSite(t)
	importHall(t, site, "hall", 3)
	got := call(t, "GET", "/v1/"+site+"/maps/hall/revisions/1/manifest", nil, nil)
	if got.status != http.StatusOK {
		t.Fatalf("status %d: %s", got.status, got.body)
	}
	var manifest tileManifest
	if err := json.Unmarshal(got.body, &manifest); err != nil {
		t.Fatal(err)
	}
	return site, got, manifest
}

func hexOf(t *testing.T, encoded string) string {
	t.Helper()
	digest, err := base64.StdEncoding.DecodeString(encoded)
	if err != nil || len(digest) != 32 {
		t.Fatalf("%q: %v", encoded, err)
	}
	return hex.EncodeToString(digest)
}

func TestManifestsAndTilesAreKeptForEver(t *testing.T) {
	site, got, manifest := withHall(t)
	if !manifest.DisplayOnly || manifest.Width != 600 || len(manifest.Levels) < 2 {
		t.Fatalf("%+v", manifest)
	}
	const kept = "private, max-age=31536000, immutable"
	if got.header.Get("Cache-Control") != kept {
		t.Errorf("cache control %q", got.header.Get("Cache-Control"))
	}
	again := call(t, "GET", "/v1/"+manifest.Revision+"/manifest", nil, header{"If-None-Match": got.header.Get("ETag")})
	if again.status != http.StatusNotModified || len(again.body) != 0 {
		t.Errorf("status %d with %d bytes", again.status, len(again.body))
	}
	classes, _ := base64.StdEncoding.DecodeString(manifest.Classes)
	for _, level := range manifest.Levels {
		path := "/v1/" + site + "/tiles/" + hexOf(t, level.Tiles[0].Sha256)
		plain := call(t, "GET", path, nil, header{"Accept-Encoding": "identity"})
		if plain.status != http.StatusOK || len(plain.body) != 65536 || plain.header.Get("Cache-Control") != kept {
			t.Fatalf("status %d, %d bytes, %v", plain.status, len(plain.body), plain.header)
		}
		if class := classes[plain.body[10*256+3>>level.Zoom]]; class != 2 {
			t.Errorf("zoom %d: the wall is of class %d", level.Zoom, class)
		}
		zipped := call(t, "GET", path, nil, header{"Accept-Encoding": "gzip"})
		reader, err := gzip.NewReader(bytes.NewReader(zipped.body))
		if err != nil || zipped.header.Get("Content-Encoding") != "gzip" {
			t.Fatalf("%v: %v", err, zipped.header)
		}
		if cells, _ := io.ReadAll(reader); !bytes.Equal(cells, plain.body) {
			t.Error("gzip gives other cells")
		}
		frame := call(t, "GET", path, nil, header{"Accept-Encoding": "gzip, zstd"})
		decoder, _ := zstd.NewReader(nil)
		cells, err := decoder.DecodeAll(frame.body, nil)
		if err != nil || frame.header.Get("Content-Encoding") != "zstd" || !bytes.Equal(cells, plain.body) {
			t.Errorf("zstd: %v: %v", err, frame.header)
		}
		known := call(t, "GET", path, nil, header{"If-None-Match": plain.header.Get("ETag")})
		if known.status != http.StatusNotModified {
			t.Errorf("status %d", known.status)
		}
	}
}

func TestManyTilesComeInOneAnswer(t *testing.T) {
	site, _, manifest := withHall(t)
	var digests []string
	for _, tile := range manifest.Levels[0].Tiles {
		digests = append(digests, hexOf(t, tile.Sha256))
	}
	body, _ := json.Marshal(map[string]any{"sha256": digests})
	seen := map[string]bool{}
	for _, form := range []struct{ query, encoding string }{{"", "identity"}, {"?encoding=zstd", "gzip"}} {
		got := call(t, "POST", "/v1/"+site+"/tiles:batch"+form.query, bytes.NewReader(body),
			header{"Content-Type": "application/json", "Accept-Encoding": form.encoding})
		if got.status != http.StatusOK {
			t.Fatalf("status %d: %s", got.status, got.body)
		}
		for rest := got.body; len(rest) > 0; {
			size := binary.LittleEndian.Uint32(rest[32:])
			if form.query == "" && size != 65536 {
				t.Errorf("%d bytes", size)
			}
			seen[form.query+hex.EncodeToString(rest[:32])] = true
			rest = rest[36+size:]
		}
	}
	distinct := map[string]bool{}
	for _, digest := range digests {
		distinct[digest] = true
	}
	if len(seen) != 2*len(distinct) {
		t.Errorf("%d tiles of %d", len(seen), len(distinct))
	}
}

func TestATileIsAPicture(t *testing.T) {
	site, _, manifest := withHall(t)
	got := call(t, "GET", "/v1/"+site+"/tiles/"+hexOf(t, manifest.Levels[0].Tiles[0].Sha256)+".png", nil, nil)
	picture, err := png.Decode(bytes.NewReader(got.body))
	if err != nil || got.header.Get("Content-Type") != "image/png" {
		t.Fatalf("status %d: %v", got.status, err)
	}
	if r, _, _, _ := picture.At(3, 250).RGBA(); r != 0 {
		t.Errorf("the wall is %d", r)
	}
	if r, _, _, a := picture.At(9, 250).RGBA(); r < 0xf000 || a != 0xffff {
		t.Errorf("the floor is %d %d", r, a)
	}
}

func TestAnOverviewHasAllMaps(t *testing.T) {
	site, _, _ := withHall(t)
	got := call(t, "GET", "/v1/"+site+"/overview?level=0", nil, header{"Accept-Encoding": "identity"})
	index, cells, _ := bytes.Cut(got.body, []byte("\n"))
	var overview struct {
		Thumbnails []struct {
			Revision              string
			ResolutionM           float64
			Width, Height, Offset int
		}
	}
	if err := json.Unmarshal(index, &overview); err != nil || len(overview.Thumbnails) != 1 {
		t.Fatalf("status %d, %v: %s", got.status, err, index)
	}
	one := overview.Thumbnails[0]
	if one.Revision != site+"/maps/hall/revisions/1" || one.Width*one.Height != len(cells) || one.Width > 64 {
		t.Errorf("%+v with %d cells", one, len(cells))
	}
	if cells[one.Offset] != 2 || cells[one.Offset+5] != 1 {
		t.Errorf("cells %v", cells[:8])
	}
	if again := call(t, "GET", "/v1/"+site+"/overview?level=0", nil,
		header{"If-None-Match": got.header.Get("ETag")}); again.status != http.StatusNotModified {
		t.Errorf("status %d", again.status)
	}
}

func TestWrongTilesAreRefused(t *testing.T) {
	site := newSite(t)
	unknown := hex.EncodeToString(bytes.Repeat([]byte{7}, 32))
	for _, c := range []struct {
		method, path, body string
		status             int
	}{
		{"GET", "/tiles/" + unknown, "", http.StatusNotFound},
		{"GET", "/tiles/" + unknown + ".png", "", http.StatusNotFound},
		{"GET", "/tiles/nonsense", "", http.StatusBadRequest},
		{"GET", "/maps/hall/revisions/1/manifest", "", http.StatusNotFound},
		{"GET", "/overview?level=x", "", http.StatusBadRequest},
		{"POST", "/tiles:batch", `{"sha256": []}`, http.StatusBadRequest},
		{"POST", "/tiles:batch", `{"sha256": ["` + unknown + `"]}`, http.StatusNotFound},
		{"POST", "/tiles:batch", `[1`, http.StatusBadRequest},
	} {
		var body io.Reader
		headers := header{}
		if c.method == "POST" {
			body, headers = bytes.NewReader([]byte(c.body)), header{"Content-Type": "application/json"}
		}
		if got := call(t, c.method, "/v1/"+site+c.path, body, headers); got.status != c.status {
			t.Errorf("%s %s: status %d, expected %d: %s", c.method, c.path, got.status, c.status, got.body)
		}
	}
}
