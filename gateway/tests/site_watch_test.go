// SPDX-License-Identifier: Apache-2.0

package tests

import (
	"encoding/json"
	"net/http"
	"testing"
)

// siteMessage is the part of WatchSiteResponse that the tests look at.
type siteMessage struct {
	ResumeToken string
	Start       *struct {
		ServerVersion string
		Reset         bool
	}
	Graph *struct {
		Maps []struct{ Map string }
	}
	Robots []struct {
		Robot          string
		PoseMapRobot   struct{ X float64 }
		PoseWorldRobot struct{ X float64 }
	}
	Sessions []struct{ Session, State string }
	More     bool
}

func siteMessageOf(t *testing.T, data string) siteMessage {
	t.Helper()
	var message siteMessage
	if err := json.Unmarshal([]byte(data), &message); err != nil {
		t.Fatalf("%v: %s", err, data)
	}
	return message
}

func TestSseResume_ABrowserSeesASiteAndGoesOnWhereItsStreamWasCut(t *testing.T) {
	site := newSite(t)
	path := "/v1/" + site + ":watch?rateHz=20"
	first := watch(t, path, "text/event-stream", nil)
	opened := first.next(t)
	begin := siteMessageOf(t, opened.data)
	if begin.Start == nil || !begin.Start.Reset || begin.Start.ServerVersion == "" {
		t.Errorf("start %+v", begin.Start)
	}
	if begin.Graph == nil || len(begin.Graph.Maps) != 1 || begin.Graph.Maps[0].Map != site+"/maps/hall" {
		t.Errorf("graph %+v", begin.Graph)
	}
	if opened.id != begin.ResumeToken || opened.id == "" {
		t.Errorf("id %q, token %q", opened.id, begin.ResumeToken)
	}
	report(t, site, 1.5)
	last := opened.id
	for robots, sessions := 0, 0; robots == 0 || sessions == 0; {
		seen := first.next(t)
		message := siteMessageOf(t, seen.data)
		if len(message.Robots) > 0 && message.Robots[0].PoseWorldRobot.X == 1.5 {
			robots++
		}
		if len(message.Sessions) > 0 && message.Sessions[0].State == "STATE_RECORDING" {
			sessions++
		}
		last = seen.id
	}
	first.close()
	report(t, site, 2.5)
	second := watch(t, path, "text/event-stream", header{"Last-Event-ID": last})
	for at := 0; ; at++ {
		message := siteMessageOf(t, second.next(t).data)
		if at == 0 && (message.Start == nil || message.Start.Reset) {
			t.Errorf("start %+v", message.Start)
		}
		if message.Graph != nil {
			t.Errorf("the graph came again: %+v", message.Graph)
		}
		if len(message.Robots) > 0 {
			if message.Robots[0].PoseMapRobot.X != 2.5 {
				t.Errorf("what was seen before the cut came again: %+v", message.Robots)
			}
			return
		}
	}
}

func TestNdjson_AProgramReadsALineForEachMessageOfASite(t *testing.T) {
	site := newSite(t)
	s := watch(t, "/v1/"+site+":watch", "application/x-ndjson", nil)
	line, err := s.reader.ReadString('\n')
	if err != nil {
		t.Fatal(err)
	}
	var message struct{ Result siteMessage }
	if err := json.Unmarshal([]byte(line), &message); err != nil || message.Result.Start == nil {
		t.Errorf("%v: %s", err, line)
	}
	unknown := watch(t, "/v1/sites/nowhere:watch", "text/event-stream", nil)
	if unknown.response.StatusCode != http.StatusNotFound {
		t.Errorf("status %d", unknown.response.StatusCode)
	}
}
