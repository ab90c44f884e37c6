// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"context"
	"encoding/json"
	"net/http"
	"os"
	"slices"
	"strings"
	"testing"

	"github.com/getkin/kin-openapi/openapi3"
	"google.golang.org/protobuf/encoding/protojson"
	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/types/descriptorpb"

	pb "enfilade/gateway/gen/enfilade/v1"
	"enfilade/gateway/internal/openapi"
)

// RPCs that clients stream to: over HTTP they are uploads of files, or not to be had.
var withoutRule = []string{"IngestService.StreamRecords", "LinkPointService.AttachEvidence", "MapService.ImportMap",
	"PriorMapService.ImportPriorMap"}

// ruleless names the RPCs of `set` that have neither a rule nor a place in withoutRule, and those that have both.
func ruleless(set *descriptorpb.FileDescriptorSet, rules string) (wrong []string, count int) {
	for _, file := range set.GetFile() {
		for _, service := range file.GetService() {
			for _, method := range service.GetMethod() {
				name := service.GetName() + "." + method.GetName()
				bound := strings.Contains(rules, "selector: enfilade.v1."+name+"\n")
				if bound == slices.Contains(withoutRule, name) {
					wrong = append(wrong, name)
				}
				count++
			}
		}
	}
	return wrong, count
}

func TestGatewayCoverage_EveryRpcHasARule(t *testing.T) {
	content, err := os.ReadFile("../gen/descriptors.binpb")
	if err != nil {
		t.Fatal(err)
	}
	var set descriptorpb.FileDescriptorSet
	if err := proto.Unmarshal(content, &set); err != nil {
		t.Fatal(err)
	}
	rules, err := os.ReadFile("../../proto/gateway.yaml")
	if err != nil {
		t.Fatal(err)
	}
	wrong, count := ruleless(&set, string(rules))
	if len(wrong) > 0 || count < 56 {
		t.Errorf("of %d RPCs these have no rule, or have one and should not: %v", count, wrong)
	}
	added := &descriptorpb.MethodDescriptorProto{Name: proto.String("PaintMap")}
	for _, file := range set.GetFile() {
		for _, service := range file.GetService() {
			if service.GetName() == "MapService" {
				service.Method = append(service.Method, added)
			}
		}
	}
	if wrong, _ := ruleless(&set, string(rules)); !slices.Equal(wrong, []string{"MapService.PaintMap"}) {
		t.Errorf("an RPC that is added without a rule is not found: %v", wrong)
	}
}

func TestOpenapi_TheDocumentDescribesTheApi(t *testing.T) {
	got := call(t, "GET", "/openapi.json", nil, nil)
	document, err := openapi3.NewLoader().LoadFromData(got.body)
	if err != nil {
		t.Fatal(err)
	}
	if err := document.Validate(context.Background()); err != nil {
		t.Error(err)
	}
	if string(got.body) != string(openapi.Document) || document.Paths.Len() < 46 {
		t.Errorf("%d paths", document.Paths.Len())
	}
	again := call(t, "GET", "/openapi.json", nil, header{"If-None-Match": got.header.Get("ETag")})
	if again.status != http.StatusNotModified {
		t.Errorf("status %d", again.status)
	}
}

func TestOpenapi_AnswersAreThoseOfTheRpc(t *testing.T) {
	site := newSite(t)
	maps := pb.NewMapServiceClient(shared.direct)
	direct, err := maps.GetMap(t.Context(), &pb.GetMapRequest{Name: site + "/maps/hall"})
	if err != nil {
		t.Fatal(err)
	}
	got := call(t, "GET", "/v1/"+site+"/maps/hall", nil, nil)
	var rest pb.GetMapResponse
	if err := protojson.Unmarshal(got.body, &rest); err != nil {
		t.Fatal(err)
	}
	if !proto.Equal(direct, &rest) {
		t.Errorf("over HTTP: %v\nby gRPC: %v", &rest, direct)
	}
	updated := must(t, "PATCH", "/v1/"+site+"/maps/hall?updateMask=level,displayName", `{"level": 3, "displayName": "Great hall"}`)
	if changed := updated["map"].(map[string]any); changed["level"] != 3.0 || changed["displayName"] != "Great hall" {
		t.Errorf("map %v", changed)
	}
}

func TestOpenapi_ErrorsHaveTheirStatusAndSayWhy(t *testing.T) {
	site := newSite(t)
	stale := must(t, "GET", "/v1/"+site+"/maps/hall", "")["map"].(map[string]any)["etag"].(string)
	must(t, "PATCH", "/v1/"+site+"/maps/hall?updateMask=level", `{"level": 2}`)
	jsonBody := header{"Content-Type": "application/json"}
	for _, c := range []struct {
		method, path, body string
		status             int
		says               string
	}{
		{"GET", "/v1/" + site + "/maps/nowhere", "", http.StatusNotFound, "nowhere"},
		{"POST", "/v1/" + site + "/maps?mapId=hall", `{"displayName": "Other"}`, http.StatusConflict, "hall"},
		{"POST", "/v1/" + site + "/maps", `{"displayName": 5}`, http.StatusBadRequest, "displayName"},
		{"POST", "/v1/" + site + "/maps", `{`, http.StatusBadRequest, ""},
		{"PATCH", "/v1/" + site + "/maps/hall?updateMask=level", `{"level": 1, "etag": "` + stale + `"}`,
			http.StatusConflict, "changed"},
		{"GET", "/v1/nothing", "", http.StatusNotFound, "/v1/nothing"},
		{"GET", "/nothing.txt", "", http.StatusNotFound, "/nothing.txt"},
		{"PUT", "/v1/" + site, `{}`, http.StatusMethodNotAllowed, "PUT"},
		{"GET", "/v1/" + site + "/blobs/zz", "", http.StatusBadRequest, "sha256"},
		{"GET", "/v1/" + site + "/maps/hall/files?format=bmp", "", http.StatusBadRequest, "bmp"},
		// Cut short within one of these characters.
		{"GET", "/v1/" + site + "/robots/" + strings.Repeat("%E2%89%88", 200) + "/globalPose", "", http.StatusBadRequest, "robot"},
	} {
		got := call(t, c.method, c.path, strings.NewReader(c.body), jsonBody)
		var body struct {
			Code    int
			Message string
		}
		if err := json.Unmarshal(got.body, &body); err != nil || body.Code == 0 || body.Message == "" {
			t.Errorf("%s %s: no google.rpc.Status: %s", c.method, c.path, got.body)
		}
		if got.status != c.status || !strings.Contains(body.Message, c.says) {
			t.Errorf("%s %s: status %d (wanted %d): %s", c.method, c.path, got.status, c.status, got.body)
		}
	}
}

func TestSecurity_TheAuditTrailNamesTheGatewaysCaller(t *testing.T) {
	site := newSite(t)
	forged := header{"Content-Type": "application/json", "Grpc-Metadata-Enfilade-Actor": "root", "Enfilade-Actor": "root",
		"Cookie": "enfilade-actor=root"}
	call(t, "POST", "/v1/"+site+"/robots?robotId=r2", strings.NewReader(`{"displayName": "Two"}`), forged)
	entries := must(t, "GET", "/v1/"+site+"/auditEntries", "")["entries"].([]any)
	if len(entries) < 4 {
		t.Fatalf("%d entries", len(entries))
	}
	for _, entry := range entries {
		if actor := entry.(map[string]any)["actor"]; actor != "gateway:127.0.0.1" {
			t.Errorf("actor %v", actor)
		}
	}
}
