// SPDX-License-Identifier: Apache-2.0

package files

import (
	"crypto/sha256"
	"encoding/json"
	"net/http"
	"strings"
	"testing"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "enfilade/gateway/gen/enfilade/v1"
)

const hall = "sites/s/maps/hall"

// areas is a server with the areas of one map, which keeps what it was asked.
type areas struct {
	pb.UnimplementedMapAreaServiceServer
	asked *pb.ExportMapAreasRequest
}

func (a *areas) ExportMapAreas(request *pb.ExportMapAreasRequest, stream grpc.ServerStreamingServer[pb.ExportMapAreasResponse]) error {
	a.asked = request
	if request.GetParent() != hall {
		return status.Error(codes.NotFound, request.GetParent()+" does not exist")
	}
	contents := map[pb.MapAreaFormat][][2]string{
		pb.MapAreaFormat_MAP_AREA_FORMAT_GEOJSON:      {{"areas.geojson", "{}"}},
		pb.MapAreaFormat_MAP_AREA_FORMAT_NAV2_KEEPOUT: {{"keepout.pgm", "P5 keepout"}, {"keepout.yaml", "mode: raw"}},
		pb.MapAreaFormat_MAP_AREA_FORMAT_NAV2_SPEED:   {{"speed.pgm", "P5 speed"}, {"speed.yaml", "mode: raw"}},
	}[request.GetFormat()]
	manifest := &pb.ExportMapAreasManifest{}
	for _, file := range contents {
		digest := sha256.Sum256([]byte(file[1]))
		manifest.Files = append(manifest.Files,
			&pb.FileEntry{Name: file[0], SizeBytes: int64(len(file[1])), Sha256: digest[:]})
	}
	if err := stream.Send(&pb.ExportMapAreasResponse{Part: &pb.ExportMapAreasResponse_Manifest{Manifest: manifest}}); err != nil {
		return err
	}
	for index, file := range contents {
		err := stream.Send(&pb.ExportMapAreasResponse{Part: &pb.ExportMapAreasResponse_Chunk{
			Chunk: &pb.FileChunk{File: int32(index), Data: []byte(file[1])}}})
		if err != nil {
			return err
		}
	}
	return nil
}

func servingAreas(t *testing.T) (*areas, http.Handler) {
	t.Helper()
	server := &areas{}
	return server, behindGateway(t, func(service *grpc.Server) { pb.RegisterMapAreaServiceServer(service, server) })
}

func TestAreaFilesAreListedWithTheirPaths(t *testing.T) {
	server, handler := servingAreas(t)
	answer := get(t, handler, "GET", "/v1/"+hall+"/areas/files?format=nav2-keepout&robotType=forklift&time=2026-01-01T01:00:00%2B01:00", "")
	if answer.Code != http.StatusOK {
		t.Fatalf("%d %s", answer.Code, answer.Body)
	}
	var listed struct {
		Map   string
		Files []struct{ Name, Path string }
	}
	if err := json.Unmarshal(answer.Body.Bytes(), &listed); err != nil {
		t.Fatal(err)
	}
	if listed.Map != hall || len(listed.Files) != 2 || listed.Files[1].Name != "keepout.yaml" {
		t.Errorf("%+v", listed)
	}
	if server.asked.GetRobotType() != "forklift" || server.asked.GetTime().GetSeconds() != 1767225600 {
		t.Errorf("asked %v", server.asked)
	}
	// The path is where the file is, for the same robots and time.
	server.asked = nil
	file := get(t, handler, "GET", listed.Files[0].Path, "")
	if file.Code != http.StatusOK || file.Body.String() != "P5 keepout" {
		t.Errorf("%s: %d %s", listed.Files[0].Path, file.Code, file.Body)
	}
	if server.asked.GetRobotType() != "forklift" || server.asked.GetTime().GetSeconds() != 1767225600 {
		t.Errorf("asked %v", server.asked)
	}
}

func TestAreaFilesAreSentByTheirName(t *testing.T) {
	_, handler := servingAreas(t)
	for name, mediaType := range map[string]string{
		"areas.geojson": "application/geo+json", "keepout.pgm": "image/x-portable-graymap", "speed.yaml": "application/yaml",
	} {
		answer := get(t, handler, "GET", "/v1/"+hall+"/areas/files/"+name, "")
		if answer.Code != http.StatusOK || answer.Header().Get("Content-Type") != mediaType {
			t.Errorf("%s: %d %s", name, answer.Code, answer.Header().Get("Content-Type"))
		}
		if again := get(t, handler, "GET", "/v1/"+hall+"/areas/files/"+name, answer.Header().Get("ETag")); again.Code != http.StatusNotModified {
			t.Errorf("%s again: %d", name, again.Code)
		}
	}
	if answer := get(t, handler, "GET", "/v1/"+hall+"/areas/files", ""); !strings.Contains(answer.Body.String(), "areas.geojson") {
		t.Errorf("without a format: %s", answer.Body)
	}
}

func TestWrongAddressesOfAreasAreRefused(t *testing.T) {
	_, handler := servingAreas(t)
	for path, code := range map[string]int{
		"/v1/" + hall + "/areas/files?format=shapefile":   http.StatusBadRequest,
		"/v1/" + hall + "/areas/files?time=noon":          http.StatusBadRequest,
		"/v1/" + hall + "/areas/files/areas.shp":          http.StatusNotFound,
		"/v1/" + hall + "/areas/files/no-ending":          http.StatusNotFound,
		"/v1/sites/s/maps/none/areas/files":               http.StatusNotFound,
		"/v1/sites/s/maps/none/areas/files/areas.geojson": http.StatusNotFound,
	} {
		if answer := get(t, handler, "GET", path, ""); answer.Code != code {
			t.Errorf("%s: %d, expected %d: %s", path, answer.Code, code, answer.Body)
		}
	}
}
