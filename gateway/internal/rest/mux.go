// SPDX-License-Identifier: Apache-2.0

// Package rest maps HTTP and JSON onto the RPCs, as proto/gateway.yaml says.
package rest

import (
	"context"
	"net"
	"net/http"
	"net/textproto"
	"net/url"
	"regexp"
	"strings"

	"github.com/grpc-ecosystem/grpc-gateway/v2/runtime"
	"github.com/grpc-ecosystem/grpc-gateway/v2/utilities"
	"google.golang.org/grpc"
	"google.golang.org/grpc/metadata"
	"google.golang.org/grpc/status"
	"google.golang.org/protobuf/encoding/protojson"
	"google.golang.org/protobuf/proto"

	pb "enfilade/gateway/gen/enfilade/v1"
)

// EventStream and Lines are the media types in which a client can ask for a stream. Without either it gets JSON, one
// object a line, as with Lines, and with all fields.
const (
	EventStream = "text/event-stream"
	Lines       = "application/x-ndjson"
)

type register func(context.Context, *runtime.ServeMux, *grpc.ClientConn) error

// NewMux returns the handler of all RPCs that proto/gateway.yaml has a rule for.
func NewMux(ctx context.Context, server *grpc.ClientConn) (*runtime.ServeMux, error) {
	// Streams leave out fields that have their default value: these are a third of a pose's bytes.
	slim := runtime.JSONPb{UnmarshalOptions: protojson.UnmarshalOptions{}}
	// Unset messages are left out: null would be of no type.
	full := runtime.JSONPb{MarshalOptions: protojson.MarshalOptions{EmitDefaultValues: true}}
	mux := runtime.NewServeMux(
		runtime.WithMarshalerOption(runtime.MIMEWildcard, &answers{full}),
		runtime.WithMarshalerOption(Lines, &lines{slim}),
		runtime.WithMarshalerOption(EventStream, &events{slim}),
		runtime.WithIncomingHeaderMatcher(passToServer),
		runtime.WithOutgoingHeaderMatcher(passToClient),
		runtime.WithForwardResponseOption(tellGraphVersion),
		runtime.WithMetadata(callerOf),
		runtime.WithErrorHandler(handleError),
		runtime.SetQueryParameterParser(&queryParser{}),
		runtime.WithStreamErrorHandler(func(_ context.Context, err error) *status.Status { return problemOf(err) }),
		runtime.WithRoutingErrorHandler(handleRoutingError),
		// A form that another site posts must reach nothing.
		runtime.WithDisablePathLengthFallback(),
		runtime.WithDisableHTTPMethodOverride(),
	)
	for _, service := range []register{
		pb.RegisterGraphServiceHandler, pb.RegisterIngestServiceHandler, pb.RegisterLinkPointServiceHandler,
		pb.RegisterLocalizationServiceHandler, pb.RegisterMapAreaServiceHandler, pb.RegisterMapEditServiceHandler,
		pb.RegisterMapServiceHandler, pb.RegisterPriorMapServiceHandler,
		pb.RegisterRasterServiceHandler, pb.RegisterRobotServiceHandler, pb.RegisterServerServiceHandler,
		pb.RegisterSessionServiceHandler, pb.RegisterSiteServiceHandler, pb.RegisterWatchServiceHandler,
	} {
		if err := service(ctx, mux, server); err != nil {
			return nil, err
		}
	}
	return mux, nil
}

type queryParser struct{ runtime.DefaultQueryParser }

// Parse takes the paths of a field mask as protobuf's JSON has them (displayName), too; the runtime knows display_name only.
func (p *queryParser) Parse(message proto.Message, values url.Values, filter *utilities.DoubleArray) error {
	for _, name := range []string{"updateMask", "update_mask"} {
		for i, paths := range values[name] {
			values[name][i] = capital.ReplaceAllStringFunc(paths, func(letter string) string { return "_" + strings.ToLower(letter) })
		}
	}
	return p.DefaultQueryParser.Parse(message, values, filter)
}

var capital = regexp.MustCompile("[A-Z]")

// Nothing that a client sends may pass for what the gateway says of it, such as its actor.
func passToServer(header string) (string, bool) {
	switch textproto.CanonicalMIMEHeaderKey(header) {
	case "Traceparent", "Tracestate", "X-Request-Id", "Enfilade-Min-Graph-Version":
		return header, true
	}
	return "", false
}

func passToClient(header string) (string, bool) {
	if textproto.CanonicalMIMEHeaderKey(header) == "X-Request-Id" {
		return "X-Request-Id", true
	}
	return "", false
}

// tellGraphVersion passes on which version of the graph has a call's change. The server says it behind its answer, where
// fetch() of a browser cannot read it; here it is a header.
func tellGraphVersion(ctx context.Context, w http.ResponseWriter, _ proto.Message) error {
	if told, ok := runtime.ServerMetadataFromContext(ctx); ok {
		for _, version := range told.TrailerMD.Get("enfilade-graph-version") {
			w.Header().Add("Enfilade-Graph-Version", version)
		}
	}
	return nil
}

// CallerOf names the caller for the audit trail.
func CallerOf(r *http.Request) string {
	host, _, err := net.SplitHostPort(r.RemoteAddr)
	if err != nil {
		host = "local"
	}
	return "gateway:" + host
}

// ContextOf a call for a request, with its caller and what else passes to the server; ends with the request.
func ContextOf(r *http.Request) context.Context {
	told := callerOf(r.Context(), r)
	for header, values := range r.Header {
		if name, passes := passToServer(header); passes {
			told.Append(name, values...)
		}
	}
	return metadata.NewOutgoingContext(r.Context(), told)
}

func callerOf(_ context.Context, r *http.Request) metadata.MD {
	return metadata.Pairs("enfilade-actor", CallerOf(r))
}
