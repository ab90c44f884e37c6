// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"bytes"
	"fmt"
	"image"
	"image/color"
	"image/png"
	"net/http"
	"strings"
	"testing"
	"time"
)

// withYard adds a copy of the hall, a quarter turn to the left and at (10, 10) in the world.
func withYard(t *testing.T, site string) {
	t.Helper()
	must(t, "POST", "/v1/"+site+"/maps?mapId=yard", `{"displayName": "Yard"}`)
	importHall(t, site, "yard", 3)
	must(t, "POST", "/v1/"+site+"/linkPoints", fmt.Sprintf(`{"kind": "KIND_DOOR", "anchors": [
		{"map": "%[1]s/maps/hall", "poseMapPlace": {"pose": {"x": 10, "y": 10}}},
		{"map": "%[1]s/maps/yard", "poseMapPlace": {"pose": {"yaw": -1.5707963267948966}}}]}`, site))
	// The graph is optimised soon after, by itself; until then its version is about to change.
	for range 600 {
		graph := must(t, "GET", "/v1/"+site+"/graph", "")["graph"].(map[string]any)
		if graph["solutionVersion"] != "0" {
			return
		}
		time.Sleep(100 * time.Millisecond)
	}
	t.Fatal("the graph is not optimised")
}

func composite(t *testing.T, site, query string) (image.Image, answer) {
	t.Helper()
	got := call(t, "GET", "/v1/"+site+"/composite.png"+query, nil, nil)
	picture, err := png.Decode(bytes.NewReader(got.body))
	if err != nil || got.status != http.StatusOK || got.header.Get("Content-Type") != "image/png" {
		t.Fatalf("status %d: %v: %.200s", got.status, err, got.body)
	}
	return picture, got
}

func colourAt(picture image.Image, x, y int) color.NRGBA {
	return color.NRGBAModel.Convert(picture.At(x, y)).(color.NRGBA)
}

var (
	nothing = color.NRGBA{}
	black   = color.NRGBA{0, 0, 0, 255}
	white   = color.NRGBA{255, 255, 255, 255}
)

func TestACompositeShowsTheMapsWhereTheGraphPlacesThem(t *testing.T) {
	site, _, _ := withHall(t)
	withYard(t, site)
	// A pixel is a cell of 5 cm; the box begins at (-10, -5) and ends at (30, 25).
	const query = "?bbox_world=-10,-5,30,25&width=800"
	picture, got := composite(t, site, query)
	if size := picture.Bounds().Size(); size != image.Pt(800, 600) {
		t.Fatalf("size %v", size)
	}
	at := func(x, y float64) color.NRGBA { return colourAt(picture, int((x+10)/0.05), int((25-y)/0.05)) }
	for _, c := range []struct {
		x, y  float64
		shown color.NRGBA
	}{
		{0.17, 3, black}, {0.22, 3, white}, {0.07, 3, white}, {29.9, 14.9, white}, {15, 15.1, nothing},
		{-3, 10.17, black}, {-3, 10.22, white}, {-3, 9.9, nothing}, {-3, 24.9, white}, {-5.1, 20, nothing},
		{5, 10.17, black}, // where both are, the wall of one is not hidden by the floor of the other
	} {
		if shown := at(c.x, c.y); shown != c.shown {
			t.Errorf("(%g, %g) is %v, expected %v", c.x, c.y, shown, c.shown)
		}
	}
	if bounds := got.header.Get("Enfilade-Bbox-World"); bounds != "-10,-5,30,25" {
		t.Errorf("box %q", bounds)
	}
	known := header{"If-None-Match": got.header.Get("ETag")}
	if again := call(t, "GET", "/v1/"+site+"/composite.png"+query, nil, known); again.status != http.StatusNotModified {
		t.Errorf("status %d", again.status)
	}
	importHall(t, site, "yard", 7)
	if again := call(t, "GET", "/v1/"+site+"/composite.png"+query, nil, known); again.status != http.StatusOK {
		t.Errorf("with a new revision: status %d", again.status)
	}
}

func TestWallSurvivesZoom_ACompositeHasWallsAtEveryWidth(t *testing.T) {
	site, _, _ := withHall(t)
	for _, width := range []int{7, 60, 200, 1000, 3000} {
		picture, got := composite(t, site, fmt.Sprintf("?width=%d", width))
		size := picture.Bounds().Size()
		if size.X != width || got.header.Get("Enfilade-Graph-Version") == "" {
			t.Fatalf("width %d: %v, %v", width, size, got.header)
		}
		walls := 0
		for x := range size.X {
			if colourAt(picture, x, size.Y/2) == black {
				walls++
			}
		}
		if walls == 0 || walls > 1+width/40 {
			t.Errorf("width %d: %d pixels of a row are wall", width, walls)
		}
	}
}

func TestPicturesMayLookLikeNav2s(t *testing.T) {
	site, _, manifest := withHall(t)
	picture, _ := composite(t, site, "?bbox_world=-1,-1,3,3&width=80&palette=nav2")
	tile := call(t, "GET", "/v1/"+site+"/tiles/"+hexOf(t, manifest.Levels[0].Tiles[0].Sha256)+".png?palette=nav2", nil, nil)
	tilePicture, err := png.Decode(bytes.NewReader(tile.body))
	if err != nil {
		t.Fatal(err)
	}
	for what, greys := range map[string][2]uint8{
		"unknown": {colourAt(picture, 5, 5).R, 205}, "wall": {colourAt(picture, 23, 30).R, 0}, "floor": {colourAt(picture, 40, 30).R, 254},
		"the tile's wall": {colourAt(tilePicture, 3, 250).R, 0}, "the tile's floor": {colourAt(tilePicture, 9, 250).R, 254},
	} {
		if greys[0] != greys[1] {
			t.Errorf("%s is %d, expected %d", what, greys[0], greys[1])
		}
	}
}

func TestWrongCompositesAreRefused(t *testing.T) {
	site := newSite(t)
	for query, says := range map[string]string{
		"?width=0": "width", "?width=5000": "width", "?width=x": "width", "?level=x": "level", "?palette=pink": "palette",
		"?bbox_world=1,2,3": "bbox_world", "?bbox_world=3,0,1,2": "bbox_world", "?bbox_world=0,0,NaN,1": "bbox_world",
		"?bbox_world=0,0,1,100000": "high",
	} {
		got := call(t, "GET", "/v1/"+site+"/composite.png"+query, nil, nil)
		if got.status != http.StatusBadRequest || !strings.Contains(string(got.body), says) {
			t.Errorf("%s: status %d: %s", query, got.status, got.body)
		}
	}
	if got := call(t, "GET", "/v1/sites/nowhere/composite.png", nil, nil); got.status != http.StatusNotFound {
		t.Errorf("status %d", got.status)
	}
	empty, _ := composite(t, site, "?width=10")
	if colourAt(empty, 5, 5) != nothing {
		t.Errorf("an empty site shows %v", colourAt(empty, 5, 5))
	}
}
