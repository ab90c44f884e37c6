// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"bufio"
	"context"
	"encoding/json"
	"net/http"
	"strconv"
	"strings"
	"testing"
	"time"

	"google.golang.org/protobuf/types/known/timestamppb"

	pb "enfilade/gateway/gen/enfilade/v1"
)

// event as a browser takes it apart.
type event struct{ name, id, data string }

type stream struct {
	response *http.Response
	reader   *bufio.Reader
	cancel   context.CancelFunc
}

// watch opens a stream; the test ends it.
func watch(t *testing.T, path, accept string, headers header) *stream {
	t.Helper()
	ctx, cancel := context.WithTimeout(t.Context(), 60*time.Second)
	request, _ := http.NewRequestWithContext(ctx, "GET", shared.url+path, nil)
	request.Header.Set("Accept", accept)
	for name, value := range headers {
		request.Header.Set(name, value)
	}
	response, err := http.DefaultTransport.RoundTrip(request)
	if err != nil {
		cancel()
		t.Fatal(err)
	}
	s := &stream{response, bufio.NewReader(response.Body), cancel}
	t.Cleanup(s.close)
	return s
}

func (s *stream) close() {
	s.cancel()
	s.response.Body.Close()
}

func (s *stream) next(t *testing.T) event {
	t.Helper()
	var result event
	for {
		line, err := s.reader.ReadString('\n')
		if err != nil {
			t.Fatalf("the stream ended: %v", err)
		}
		line = strings.TrimSuffix(line, "\n")
		if line == "" {
			return result
		}
		name, value, _ := strings.Cut(line, ": ")
		switch name {
		case "event":
			result.name = value
		case "id":
			result.id = value
		case "data":
			result.data += value
		}
	}
}

// report stores a pose of robot r1.
func report(t *testing.T, site string, x float64) {
	t.Helper()
	session := strings.NewReplacer("sites/", "", "/", "-").Replace(site)
	sessions := pb.NewSessionServiceClient(shared.direct)
	_, err := sessions.CreateSession(t.Context(), &pb.CreateSessionRequest{Parent: site, SessionId: session,
		RequestId: session, Session: &pb.Session{Robot: site + "/robots/r1"}})
	if err != nil {
		t.Fatal(err)
	}
	records, err := pb.NewIngestServiceClient(shared.direct).StreamRecords(t.Context())
	if err != nil {
		t.Fatal(err)
	}
	defer records.CloseSend()
	for _, message := range []*pb.StreamRecordsRequest{
		{Request: &pb.StreamRecordsRequest_Open{Open: &pb.StreamOpen{Session: site + "/sessions/" + session}}},
		{Request: &pb.StreamRecordsRequest_PoseReport{PoseReport: &pb.PoseReport{Time: timestamppb.Now(),
			Map: site + "/maps/hall", PoseMapRobot: &pb.PoseWithCovariance{Pose: &pb.Pose2{X: x}}}}},
	} {
		if err := records.Send(message); err != nil {
			t.Fatal(err)
		}
	}
}

func xOf(t *testing.T, data string) float64 {
	t.Helper()
	var message struct {
		GlobalPoses []struct {
			PoseWorldRobot struct{ Pose struct{ X float64 } }
		}
	}
	if err := json.Unmarshal([]byte(data), &message); err != nil {
		t.Fatalf("%v: %s", err, data)
	}
	if len(message.GlobalPoses) == 0 {
		return 0
	}
	return message.GlobalPoses[0].PoseWorldRobot.Pose.X
}

func TestSseResume_ABrowserSeesPosesAndGoesOnWhereItsStreamWasCut(t *testing.T) {
	site := newSite(t)
	begin := time.Now()
	first := watch(t, "/v1/"+site+"/globalPoses:watch?rateHz=20", "text/event-stream", nil)
	if media := first.response.Header.Get("Content-Type"); media != "text/event-stream" {
		t.Errorf("media type %q", media)
	}
	opened := first.next(t)
	t.Logf("the first event came after %v", time.Since(begin))
	if opened.id == "" {
		t.Errorf("no id: %+v", opened)
	}
	report(t, site, 1.5)
	seen := first.next(t)
	for xOf(t, seen.data) != 1.5 {
		seen = first.next(t)
	}
	first.close()
	report(t, site, 2.5)
	second := watch(t, "/v1/"+site+"/globalPoses:watch?rateHz=20", "text/event-stream", header{"Last-Event-ID": seen.id})
	for x := xOf(t, second.next(t).data); x != 2.5; x = xOf(t, second.next(t).data) {
		if x == 1.5 {
			t.Error("what was seen before the cut came again")
		}
	}
}

func TestNdjson_AProgramReadsALineForEachMessage(t *testing.T) {
	site := newSite(t)
	s := watch(t, "/v1/"+site+"/globalPoses:watch?rateHz=20", "application/x-ndjson", nil)
	report(t, site, 3.5)
	for {
		line, err := s.reader.ReadString('\n')
		if err != nil {
			t.Fatal(err)
		}
		var message struct{ Result json.RawMessage }
		if err := json.Unmarshal([]byte(line), &message); err != nil {
			t.Fatalf("%v: %s", err, line)
		}
		if xOf(t, string(message.Result)) == 3.5 {
			return
		}
	}
}

func TestSseResume_AStreamOfAnUnknownSiteSaysSo(t *testing.T) {
	s := watch(t, "/v1/sites/nowhere/globalPoses:watch", "text/event-stream", nil)
	if s.response.StatusCode != http.StatusNotFound {
		t.Errorf("status %d", s.response.StatusCode)
	}
}

// watchers is how many watches the server has open, by its own metrics.
func watchers(t *testing.T) int {
	t.Helper()
	response, err := http.Get("http://" + shared.metrics + "/metrics")
	if err != nil {
		t.Fatal(err)
	}
	defer response.Body.Close()
	for lines := bufio.NewScanner(response.Body); lines.Scan(); {
		if value, found := strings.CutPrefix(lines.Text(), "enfilade_watchers "); found {
			count, err := strconv.Atoi(value)
			if err != nil {
				t.Fatal(err)
			}
			return count
		}
	}
	t.Fatal("the server has no metric enfilade_watchers")
	return 0
}

// awaitWatchers returns how long it took until the server had `wanted` watches open.
func awaitWatchers(t *testing.T, wanted int) time.Duration {
	t.Helper()
	for begin := time.Now(); ; time.Sleep(10 * time.Millisecond) {
		count := watchers(t)
		if count == wanted {
			return time.Since(begin)
		}
		if time.Since(begin) > 20*time.Second {
			t.Fatalf("the server has %d open watches, wanted %d", count, wanted)
		}
	}
}

func TestNdjson_AStreamThatIsClosedEndsOnTheServer(t *testing.T) {
	site := newSite(t)
	awaitWatchers(t, 0) // those of other tests have ended
	for _, path := range []string{"/globalPoses:watch", ":watch"} {
		var open []*stream
		for range 3 {
			s := watch(t, "/v1/"+site+path, "application/x-ndjson", nil)
			if _, err := s.reader.ReadString('\n'); err != nil {
				t.Fatal(err)
			}
			open = append(open, s)
		}
		awaitWatchers(t, 3)
		open[1].close()
		t.Logf("%s: the RPC ended %v after the stream was closed", path, awaitWatchers(t, 2))
		report(t, site, 1)
		if _, err := open[2].reader.ReadString('\n'); err != nil {
			t.Errorf("%s: the other streams ended, too: %v", path, err)
		}
		open[0].close()
		open[2].close()
		awaitWatchers(t, 0)
	}
}
