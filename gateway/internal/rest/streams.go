// SPDX-License-Identifier: Apache-2.0

package rest

import (
	"bytes"
	"net/http"
	"strings"

	"github.com/grpc-ecosystem/grpc-gateway/v2/runtime"
	"google.golang.org/protobuf/proto"
	"google.golang.org/protobuf/reflect/protoreflect"
)

// answers are JSON; those of a stream are lines.
type answers struct{ runtime.JSONPb }

func (*answers) StreamContentType(any) string { return Lines }

// lines encodes a stream as JSON, one object {"result": ...} or {"error": ...} a line.
type lines struct{ runtime.JSONPb }

func (*lines) ContentType(any) string       { return Lines }
func (*lines) StreamContentType(any) string { return Lines }
func (*lines) Delimiter() []byte            { return []byte("\n") }

// events encodes a stream as server-sent events (WHATWG HTML, 9.2). An event's id is the message's resume token, which
// the browser sends as Last-Event-ID when it connects again. The event of an error is named "failed".
type events struct{ runtime.JSONPb }

func (*events) ContentType(any) string       { return EventStream }
func (*events) StreamContentType(any) string { return EventStream }
func (*events) Delimiter() []byte            { return []byte("\n\n") }

// Marshal takes what the runtime makes of a stream's messages: {"result": message} or {"error": status}.
func (e *events) Marshal(v any) ([]byte, error) {
	content, name, id := v, "", ""
	if part, ok := v.(map[string]any); ok {
		content = part["result"]
		if message, ok := content.(proto.Message); ok {
			id = resumeTokenOf(message)
		}
	} else if part, ok := v.(map[string]proto.Message); ok {
		content, name = part["error"], "failed"
	}
	data, err := e.JSONPb.Marshal(content)
	if err != nil {
		return nil, err
	}
	var out bytes.Buffer
	if name != "" {
		out.WriteString("event: " + name + "\n")
	}
	if id != "" {
		out.WriteString("id: " + id + "\n")
	}
	out.WriteString("data: ")
	out.Write(data)
	return out.Bytes(), nil
}

func resumeTokenOf(message proto.Message) string {
	fields := message.ProtoReflect().Descriptor().Fields()
	token := fields.ByName("resume_token")
	if token == nil || token.Kind() != protoreflect.StringKind {
		return ""
	}
	text := message.ProtoReflect().Get(token).String()
	if strings.ContainsAny(text, "\r\n\x00") {
		return ""
	}
	return text
}

// Resume lets a browser go on where its stream was cut: it turns Last-Event-ID into the resume token.
func Resume(next http.Handler) http.Handler {
	return http.HandlerFunc(func(w http.ResponseWriter, r *http.Request) {
		if last := r.Header.Get("Last-Event-ID"); last != "" && r.Header.Get("Accept") == EventStream {
			query := r.URL.Query()
			query.Set("resume_token", last)
			query.Del("resumeToken")
			r.URL.RawQuery = query.Encode()
		}
		next.ServeHTTP(w, r)
	})
}
