// SPDX-License-Identifier: Apache-2.0

package rest

import (
	"context"
	"encoding/json"
	"log/slog"
	"math"
	"net/http"
	"strconv"
	"strings"

	"github.com/grpc-ecosystem/grpc-gateway/v2/runtime"
	"google.golang.org/genproto/googleapis/rpc/errdetails"
	spb "google.golang.org/genproto/googleapis/rpc/status"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"
	"google.golang.org/protobuf/encoding/protojson"
)

const statusType = "application/json"

func handleError(_ context.Context, _ *runtime.ServeMux, _ runtime.Marshaler, w http.ResponseWriter, r *http.Request,
	err error) {
	WriteError(w, r, err)
}

func handleRoutingError(_ context.Context, _ *runtime.ServeMux, _ runtime.Marshaler, w http.ResponseWriter,
	r *http.Request, code int) {
	switch code {
	case http.StatusNotFound:
		WriteStatus(w, code, codes.NotFound, "there is nothing at "+r.Method+" "+r.URL.Path)
	case http.StatusMethodNotAllowed:
		WriteStatus(w, code, codes.Unimplemented, r.Method+" is not possible at "+r.URL.Path)
	default:
		WriteStatus(w, code, codes.InvalidArgument, http.StatusText(code))
	}
}

// What grpc-go says of a connection that failed has addresses and socket paths in it, and helps nobody at a browser.
var ofTheConnection = []string{"connection error:", "error reading from server:", "transport: ", "transport is closing",
	"name resolver error:", "the connection is draining"}

// problemOf an RPC that failed, in words for the client.
func problemOf(err error) *status.Status {
	problem := status.Convert(err)
	if problem.Code() != codes.Unavailable {
		return problem
	}
	for _, beginning := range ofTheConnection {
		if strings.HasPrefix(problem.Message(), beginning) {
			slog.Warn("the server cannot be reached", "message", problem.Message())
			return status.New(codes.Unavailable, "the map server cannot be reached")
		}
	}
	return problem
}

// WriteError answers with an RPC's error: google.rpc.Status as JSON, and Retry-After where it is worth trying again.
// What went wrong inside is logged, not told.
func WriteError(w http.ResponseWriter, r *http.Request, err error) {
	problem := problemOf(err)
	message := problem.Message()
	if problem.Code() == codes.Internal || problem.Code() == codes.Unknown {
		slog.Error("the server failed", "path", r.URL.Path, "code", problem.Code().String(), "message", message)
		message = "the server failed; its log has the reason"
	}
	if problem.Code() == codes.Unavailable || problem.Code() == codes.ResourceExhausted {
		w.Header().Set("Retry-After", strconv.Itoa(retryAfter(problem)))
	}
	message = strings.ToValidUTF8(message, "\uFFFD") // JSON and Protobuf take nothing else
	body := &spb.Status{Code: int32(problem.Code()), Message: message, Details: problem.Proto().GetDetails()}
	encoded, encodeErr := protojson.Marshal(body)
	if encodeErr != nil { // a detail of a type that is not known here
		body.Details = nil
		encoded, _ = protojson.Marshal(body)
	}
	write(w, runtime.HTTPStatusFromCode(problem.Code()), encoded)
}

// WriteStatus answers with an error of the gateway's own.
func WriteStatus(w http.ResponseWriter, httpStatus int, code codes.Code, message string) {
	encoded, _ := json.Marshal(map[string]any{"code": int(code), "message": message})
	write(w, httpStatus, encoded)
}

// Seconds: as the server asks, else 1.
func retryAfter(problem *status.Status) int {
	for _, detail := range problem.Details() {
		if retry, ok := detail.(*errdetails.RetryInfo); ok {
			return max(1, int(math.Ceil(retry.GetRetryDelay().AsDuration().Seconds())))
		}
	}
	return 1
}

func write(w http.ResponseWriter, httpStatus int, body []byte) {
	w.Header().Del("Trailer")
	w.Header().Del("Transfer-Encoding")
	w.Header().Set("Content-Type", statusType)
	w.Header().Set("Cache-Control", "no-store")
	w.WriteHeader(httpStatus)
	_, _ = w.Write(append(body, '\n'))
}
