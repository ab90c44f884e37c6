// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"bytes"
	"encoding/binary"
	"fmt"
	"hash/crc32"
	"io"
	"log/slog"
	"mime/multipart"
	"net/http"
	"strings"
	"testing"
	"time"

	"enfilade/gateway/internal/app"
	"enfilade/gateway/internal/files"
	"enfilade/gateway/internal/guard"
)

// hugePng says that it has `side` x `side` pixels, and has none.
func hugePng(side uint32) []byte {
	chunk := func(kind string, data []byte) []byte {
		out := binary.BigEndian.AppendUint32(nil, uint32(len(data)))
		out = append(append(out, kind...), data...)
		return binary.BigEndian.AppendUint32(out, crc32.ChecksumIEEE(out[4:]))
	}
	size := binary.BigEndian.AppendUint32(binary.BigEndian.AppendUint32(nil, side), side)
	return append(append([]byte("\x89PNG\r\n\x1a\n"), chunk("IHDR", append(size, 8, 0, 0, 0, 0))...), chunk("IEND", nil)...)
}

func TestSecurity_WrongUploadsAreRefusedAndStoreNothing(t *testing.T) {
	site := newSite(t)
	text := []byte(description)
	many := map[string][]byte{}
	for number := range 20 {
		many[fmt.Sprintf("%d.pgm", number)] = picture(10)
	}
	for name, uploaded := range map[string]map[string][]byte{
		"nothing":               {},
		"an image alone":        {"hall.pgm": picture(10)},
		"a picture that lies":   {"hall.pgm": []byte("P5\n100000 100000\n255\n"), "hall.yaml": text},
		"a bomb":                {"hall.pgm": hugePng(60_000), "hall.yaml": text},
		"a page":                {"hall.pgm": []byte("<html><script>alert(1)</script>"), "hall.yaml": text},
		"a path":                {"../../hall.pgm": picture(10), "hall.yaml": []byte(strings.Replace(description, "hall.pgm", "../../../etc/passwd", 1))},
		"more files than a map": many,
	} {
		got := upload(t, "/v1/"+site+"/maps/hall:import", nil, uploaded)
		if got.status != http.StatusBadRequest || got.json(t)["message"] == "" {
			t.Errorf("%s: status %d: %s", name, got.status, got.body)
		}
	}
	if revisions := must(t, "GET", "/v1/"+site+"/maps/hall/revisions", "")["revisions"].([]any); len(revisions) > 0 {
		t.Errorf("revisions %v", revisions)
	}
}

func TestSecurity_AnUploadThatIsTooLargeIsRefusedBeforeItHasCome(t *testing.T) {
	site := newSite(t)
	url := startGatewayOf(t, app.Options{Server: shared.address, CallTime: 30 * time.Second, Limits: guard.DefaultLimits(),
		Uploads: files.UploadLimits{Bytes: 1 << 20, Files: 16}}, slog.DiscardHandler)
	reader, writer := io.Pipe()
	form := multipart.NewWriter(writer)
	sent := make(chan int, 1)
	go func() {
		part, err := form.CreateFormFile("file", "hall.pgm")
		megabytes := 0
		for piece := bytes.Repeat([]byte{254}, 1<<20); err == nil && megabytes < 1000; megabytes++ {
			_, err = part.Write(piece)
		}
		_ = writer.CloseWithError(io.ErrUnexpectedEOF)
		sent <- megabytes
	}()
	request, _ := http.NewRequest("POST", url+"/v1/"+site+"/maps/hall:import", reader)
	request.Header.Set("Content-Type", form.FormDataContentType())
	response, err := http.DefaultTransport.RoundTrip(request)
	_ = reader.Close()
	if err == nil { // else the connection was closed before the answer was read
		defer response.Body.Close()
		if body, _ := io.ReadAll(response.Body); response.StatusCode != http.StatusBadRequest || !strings.Contains(string(body), "larger than 1048576 bytes") {
			t.Errorf("status %d: %s", response.StatusCode, body)
		}
	}
	if megabytes := <-sent; megabytes > 100 {
		t.Errorf("%d MB were taken", megabytes)
	}
}

// What a browser would run is served as a file to keep.
func TestSecurity_EvidenceThatIsNoPictureIsNeverShown(t *testing.T) {
	site, door := withDoor(t)
	for _, content := range []string{`<svg xmlns="http://www.w3.org/2000/svg"><script>alert(1)</script></svg>`, `<html><script>alert(1)</script></html>`} {
		got := call(t, "GET", attach(t, site, door, "ENCODING_PNG", []byte(content)), nil, nil)
		if got.status != http.StatusOK || got.header.Get("Content-Type") != "application/octet-stream" ||
			!strings.HasPrefix(got.header.Get("Content-Disposition"), "attachment") || got.header.Get("X-Content-Type-Options") != "nosniff" {
			t.Errorf("status %d: %v", got.status, got.header)
		}
	}
}
