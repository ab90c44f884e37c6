// SPDX-License-Identifier: Apache-2.0

package files

import (
	"bytes"
	"crypto/sha256"
	"encoding/hex"
	"encoding/json"
	"io"
	"mime/multipart"
	"net"
	"net/http"
	"net/http/httptest"
	"slices"
	"strings"
	"testing"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/credentials/insecure"
	"google.golang.org/grpc/status"

	pb "enfilade/gateway/gen/enfilade/v1"
	"enfilade/gateway/internal/rest"
)

const plan = "sites/s/priorMaps/p"

// plans is a server with one prior map, which keeps what it was asked.
type plans struct {
	pb.UnimplementedPriorMapServiceServer
	manifest *pb.ImportPriorMapManifest
	content  []byte
	chunks   int
	products []pb.PriorMapProduct
	walls    string // of walls.geojson
}

func (p *plans) ImportPriorMap(stream grpc.ClientStreamingServer[pb.ImportPriorMapRequest, pb.ImportPriorMapResponse]) error {
	for {
		request, err := stream.Recv()
		if err == io.EOF {
			break
		}
		if err != nil {
			return err
		}
		if manifest := request.GetManifest(); manifest != nil {
			p.manifest = manifest
			if manifest.GetDisplayName() == "Taken" {
				return status.Error(codes.AlreadyExists, "the display name is taken")
			}
			continue
		}
		if request.GetChunk().GetOffset() != int64(len(p.content)) {
			return status.Error(codes.InvalidArgument, "a chunk is missing")
		}
		p.content = append(p.content, request.GetChunk().GetData()...)
		p.chunks++
	}
	return stream.SendAndClose(&pb.ImportPriorMapResponse{PriorMap: &pb.PriorMap{Name: plan, State: pb.PriorMap_STATE_NEW}})
}

func (p *plans) ExportPriorMap(request *pb.ExportPriorMapRequest, stream grpc.ServerStreamingServer[pb.ExportPriorMapResponse]) error {
	if request.GetName() != plan {
		return status.Error(codes.NotFound, request.GetName()+" does not exist")
	}
	p.products = request.GetProducts()
	wanted := func(product pb.PriorMapProduct) bool {
		return len(p.products) == 0 || slices.Contains(p.products, product)
	}
	manifest := &pb.ExportPriorMapManifest{Name: request.GetName()}
	contents := []string{}
	add := func(product pb.PriorMapProduct, name, content string) {
		if wanted(product) {
			digest := sha256.Sum256([]byte(content))
			manifest.Files = append(manifest.Files,
				&pb.FileEntry{Name: name, SizeBytes: int64(len(content)), Sha256: digest[:]})
			contents = append(contents, content)
		}
	}
	add(pb.PriorMapProduct_PRIOR_MAP_PRODUCT_SHEET, "Plan 1.PNG", "sheet")
	add(pb.PriorMapProduct_PRIOR_MAP_PRODUCT_CORRECTED, "walls.geojson", p.walls)
	add(pb.PriorMapProduct_PRIOR_MAP_PRODUCT_CORRECTED, "walls.svg", "<svg/>")
	if err := stream.Send(&pb.ExportPriorMapResponse{Content: &pb.ExportPriorMapResponse_Manifest{Manifest: manifest}}); err != nil {
		return err
	}
	for index, content := range contents {
		err := stream.Send(&pb.ExportPriorMapResponse{Content: &pb.ExportPriorMapResponse_Chunk{
			Chunk: &pb.FileChunk{File: int32(index), Data: []byte(content)}}})
		if err != nil {
			return err
		}
	}
	return nil
}

// serving starts `server` behind the gateway's mux.
func serving(t *testing.T, server *plans) http.Handler {
	t.Helper()
	return behindGateway(t, func(service *grpc.Server) { pb.RegisterPriorMapServiceServer(service, server) })
}

// behindGateway starts a server, whose services `register` adds, behind the gateway's mux.
func behindGateway(t *testing.T, register func(*grpc.Server)) http.Handler {
	t.Helper()
	listener, err := net.Listen("tcp", "127.0.0.1:0")
	if err != nil {
		t.Fatal(err)
	}
	service := grpc.NewServer()
	register(service)
	go func() { _ = service.Serve(listener) }()
	t.Cleanup(service.Stop)
	connection, err := grpc.NewClient(listener.Addr().String(), grpc.WithTransportCredentials(insecure.NewCredentials()))
	if err != nil {
		t.Fatal(err)
	}
	t.Cleanup(func() { _ = connection.Close() })
	mux, err := rest.NewMux(t.Context(), connection)
	if err != nil {
		t.Fatal(err)
	}
	if err := Register(mux, connection, DefaultUploadLimits()); err != nil {
		t.Fatal(err)
	}
	return mux
}

func get(t *testing.T, handler http.Handler, method, path, etag string) *httptest.ResponseRecorder {
	t.Helper()
	request := httptest.NewRequest(method, path, nil)
	if etag != "" {
		request.Header.Set("If-None-Match", etag)
	}
	answer := httptest.NewRecorder()
	handler.ServeHTTP(answer, request)
	return answer
}

func post(t *testing.T, handler http.Handler, fields map[string]string, files ...[]byte) *httptest.ResponseRecorder {
	t.Helper()
	var body bytes.Buffer
	form := multipart.NewWriter(&body)
	for name, value := range fields {
		_ = form.WriteField(name, value)
	}
	for _, content := range files {
		part, err := form.CreateFormFile("file", "plan.svg")
		if err != nil {
			t.Fatal(err)
		}
		_, _ = part.Write(content)
	}
	_ = form.Close()
	request := httptest.NewRequest("POST", "/v1/sites/s/priorMaps:import", &body)
	request.Header.Set("Content-Type", form.FormDataContentType())
	answer := httptest.NewRecorder()
	handler.ServeHTTP(answer, request)
	return answer
}

func TestPriorMaps_AnImportPassesTheFileAndItsFieldsOn(t *testing.T) {
	server := &plans{}
	content := bytes.Repeat([]byte("wall "), chunkBytes/2)
	answer := post(t, serving(t, server), map[string]string{"display_name": "Floor 2", "level": "-2", "prior_map_id": "p",
		"page": "3", "plan_level": "L2", "layers": "A-WALL*, doors,", "measure": "1,2.5, 30,-4 = 7.25"}, content)
	var got struct{ PriorMap struct{ Name, State string } }
	if err := json.Unmarshal(answer.Body.Bytes(), &got); err != nil || answer.Code != http.StatusOK ||
		got.PriorMap.Name != plan || got.PriorMap.State != "STATE_NEW" {
		t.Fatalf("status %d: %s", answer.Code, answer.Body)
	}
	digest := sha256.Sum256(content)
	m := server.manifest
	if m.GetParent() != "sites/s" || m.GetDisplayName() != "Floor 2" || m.GetLevel() != -2 || m.GetPriorMapId() != "p" ||
		m.GetPage() != 3 || m.GetPlanLevel() != "L2" || !slices.Equal(m.GetLayers(), []string{"A-WALL*", "doors"}) {
		t.Errorf("manifest %v", m)
	}
	if measure := m.GetMeasure(); measure.GetFromX() != 1 || measure.GetFromY() != 2.5 || measure.GetToX() != 30 ||
		measure.GetToY() != -4 || measure.GetLengthM() != 7.25 {
		t.Errorf("measure %v", measure)
	}
	if file := m.GetFile(); file.GetName() != "plan.svg" || file.GetSizeBytes() != int64(len(content)) ||
		!bytes.Equal(file.GetSha256(), digest[:]) {
		t.Errorf("file %v", m.GetFile())
	}
	if !bytes.Equal(server.content, content) || server.chunks != 3 {
		t.Errorf("%d bytes in %d chunks", len(server.content), server.chunks)
	}
}

func TestPriorMaps_AWrongImportIsRefused(t *testing.T) {
	handler := serving(t, &plans{})
	file := []byte("wall")
	for name, one := range map[string]struct {
		fields map[string]string
		files  [][]byte
		status int
	}{
		"no file":       {nil, nil, http.StatusBadRequest},
		"two files":     {nil, [][]byte{file, file}, http.StatusBadRequest},
		"level":         {map[string]string{"level": "ground"}, [][]byte{file}, http.StatusBadRequest},
		"page":          {map[string]string{"page": "1.5"}, [][]byte{file}, http.StatusBadRequest},
		"measure":       {map[string]string{"measure": "1,2,3=4"}, [][]byte{file}, http.StatusBadRequest},
		"no measure":    {map[string]string{"measure": "1,2,x,3=4"}, [][]byte{file}, http.StatusBadRequest},
		"a taken name":  {map[string]string{"display_name": "Taken"}, [][]byte{file}, http.StatusConflict},
		"a taken name2": {map[string]string{"display_name": "Taken"}, [][]byte{bytes.Repeat(file, chunkBytes)}, http.StatusConflict},
	} {
		if answer := post(t, handler, one.fields, one.files...); answer.Code != one.status {
			t.Errorf("%s: status %d: %s", name, answer.Code, answer.Body)
		}
	}
}

func TestPriorMaps_TheFilesAreListedWithTheirPaths(t *testing.T) {
	handler := serving(t, &plans{walls: "{}"})
	var got struct {
		PriorMap string
		Files    []fileLink
	}
	answer := get(t, handler, "GET", "/v1/"+plan+"/files", "")
	if err := json.Unmarshal(answer.Body.Bytes(), &got); err != nil || got.PriorMap != plan || len(got.Files) != 3 {
		t.Fatalf("status %d: %s", answer.Code, answer.Body)
	}
	for _, file := range got.Files {
		sent := get(t, handler, "GET", file.Path, "")
		digest := sha256.Sum256(sent.Body.Bytes())
		if sent.Code != http.StatusOK || hex.EncodeToString(digest[:]) != file.SHA256 {
			t.Errorf("%s: status %d: %s", file.Path, sent.Code, sent.Body)
		}
	}
	if answer := get(t, handler, "GET", "/v1/"+plan+"/files?product=sheet", ""); !strings.Contains(answer.Body.String(),
		`"/v1/sites/s/priorMaps/p/files/Plan%201.PNG?product=sheet"`) || strings.Contains(answer.Body.String(), "walls") {
		t.Errorf("sheet: %s", answer.Body)
	}
	if answer := get(t, handler, "GET", "/v1/"+plan+"/files?product=all", ""); answer.Code != http.StatusBadRequest {
		t.Errorf("product=all: status %d", answer.Code)
	}
}

func TestPriorMaps_AFileIsAskedForAnewUntilItIsKnown(t *testing.T) {
	server := &plans{walls: `{"a":1}`}
	handler := serving(t, server)
	path := "/v1/" + plan + "/files/walls.geojson"
	first := get(t, handler, "GET", path, "")
	etag := first.Header().Get("ETag")
	if first.Body.String() != server.walls || first.Header().Get("Content-Type") != "application/geo+json" ||
		first.Header().Get("Cache-Control") != "private, no-cache" {
		t.Errorf("status %d: %v %s", first.Code, first.Header(), first.Body)
	}
	if !slices.Equal(server.products, []pb.PriorMapProduct{pb.PriorMapProduct_PRIOR_MAP_PRODUCT_CORRECTED}) {
		t.Errorf("asked for %v", server.products)
	}
	if again := get(t, handler, "GET", path, etag); again.Code != http.StatusNotModified {
		t.Errorf("status %d", again.Code)
	}
	if head := get(t, handler, "HEAD", path, ""); head.Code != http.StatusOK || head.Body.Len() > 0 {
		t.Errorf("HEAD: status %d, %d bytes", head.Code, head.Body.Len())
	}
	server.walls = `{"a":2}` // aligned anew
	if changed := get(t, handler, "GET", path, etag); changed.Code != http.StatusOK || changed.Body.String() != server.walls {
		t.Errorf("status %d: %s", changed.Code, changed.Body)
	}
}

func TestPriorMaps_TheSheetHasTheNameItWasImportedBy(t *testing.T) {
	handler := serving(t, &plans{})
	sheet := get(t, handler, "GET", "/v1/"+plan+"/files/Plan%201.PNG", "")
	if sheet.Body.String() != "sheet" || sheet.Header().Get("Content-Type") != "image/png" {
		t.Errorf("status %d: %v %s", sheet.Code, sheet.Header(), sheet.Body)
	}
	for _, path := range []string{plan + "/files/other.png", "sites/s/priorMaps/q/files/walls.geojson"} {
		if answer := get(t, handler, "GET", "/v1/"+path, ""); answer.Code != http.StatusNotFound {
			t.Errorf("%s: status %d", path, answer.Code)
		}
	}
}
