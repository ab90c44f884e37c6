// SPDX-License-Identifier: Apache-2.0

package main

import (
	"slices"
	"strings"
	"testing"
)

func TestArgumentsWinOverTheEnvironment(t *testing.T) {
	environment := []string{"ENFILADE_GATEWAY_LISTEN=127.0.0.1:1", "ENFILADE_GATEWAY_SERVER=maps:50051",
		"ENFILADE_GATEWAY_HOST=a.example,b.example", "ENFILADE_SERVER=unused", "HOME=/"}
	s, err := parse([]string{"--listen", "127.0.0.1:2"}, environment)
	if err != nil {
		t.Fatal(err)
	}
	if s.Listen != "127.0.0.1:2" || s.Server != "maps:50051" {
		t.Errorf("listen %q, server %q", s.Listen, s.Server)
	}
	if !slices.Contains(s.Hosts, "a.example") || !slices.Contains(s.Hosts, "b.example") {
		t.Errorf("hosts %q", s.Hosts)
	}
}

func TestWrongSettingsAreNamed(t *testing.T) {
	for _, c := range []struct {
		arguments, environment []string
		want                   string
	}{
		{nil, []string{"ENFILADE_GATEWAY_LISTNE=x"}, "ENFILADE_GATEWAY_LISTNE: there is no option"},
		{nil, []string{"ENFILADE_GATEWAY_EXPORTS=many"}, "ENFILADE_GATEWAY_EXPORTS: "},
		{[]string{"--listen", "0.0.0.0:80"}, nil, "--host"},
		{[]string{"--listen", "0.0.0.0:80", "--host", "a"}, nil, "no TLS"},
		{[]string{"serve"}, nil, `unexpected argument "serve"`},
	} {
		_, err := parse(c.arguments, c.environment)
		if err == nil || !strings.Contains(err.Error(), c.want) {
			t.Errorf("%q %q: %v", c.arguments, c.environment, err)
		}
	}
}

func TestTheManualHasEveryOption(t *testing.T) {
	page := manual()
	for _, line := range []string{`\fB\-\-server\-tls\-key\fR \fISTRING\fR`, "$ENFILADE_GATEWAY_SERVER_TLS_KEY", "(default: 127.0.0.1:8080)"} {
		if !strings.Contains(page, line) {
			t.Errorf("no %q", line)
		}
	}
}
