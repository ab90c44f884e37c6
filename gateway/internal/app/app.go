// SPDX-License-Identifier: Apache-2.0

// Package app puts the gateway together.
package app

import (
	"context"
	"errors"
	"fmt"
	"log/slog"
	"net"
	"net/http"
	"strings"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/credentials"
	"google.golang.org/grpc/credentials/insecure"
	"google.golang.org/grpc/health/grpc_health_v1"
	"google.golang.org/grpc/keepalive"

	"enfilade/gateway/internal/certificates"
	"enfilade/gateway/internal/dashboard"
	"enfilade/gateway/internal/files"
	"enfilade/gateway/internal/guard"
	"enfilade/gateway/internal/openapi"
	"enfilade/gateway/internal/rasters"
	"enfilade/gateway/internal/reference"
	"enfilade/gateway/internal/rest"
	"enfilade/gateway/internal/telemetry"
	"enfilade/gateway/internal/vectors"
)

// Options of the gateway; see the command's flags.
type Options struct {
	Listen        string
	MetricsListen string             // empty: none
	Server        string             // of enfilade-server: host:port or unix:path
	ListenTLS     certificates.Files // certificate and key; none: plain HTTP
	ServerTLS     certificates.Files // authorities; certificate and key if the server asks for them; none: no TLS
	Hosts         []string
	Origins       []string
	CallTime      time.Duration // for a call that is no stream
	Limits        guard.Limits
	Uploads       files.UploadLimits
}

const maxMessageBytes = 64 << 20 // of the server's answers

// Gateway answers over HTTP until it is stopped.
type Gateway struct {
	server   *grpc.ClientConn
	public   *http.Server
	metrics  *http.Server
	listener net.Listener
	errors   chan error
}

// Start listens; Addr tells where.
func Start(ctx context.Context, options Options, log *slog.Logger) (*Gateway, error) {
	toServer, err := credentialsFor(options, log)
	if err != nil {
		return nil, err
	}
	server, err := grpc.NewClient(options.Server,
		grpc.WithTransportCredentials(toServer),
		grpc.WithDefaultCallOptions(grpc.MaxCallRecvMsgSize(maxMessageBytes)),
		grpc.WithUnaryInterceptor(limitTime(options.CallTime)),
		grpc.WithKeepaliveParams(keepalive.ClientParameters{Time: 5 * time.Minute, Timeout: 20 * time.Second}))
	if err != nil {
		return nil, err
	}
	metrics := telemetry.NewMetrics()
	handler, err := newHandler(ctx, server, metrics, options)
	if err != nil {
		return nil, errors.Join(err, server.Close())
	}
	listener, err := net.Listen("tcp", options.Listen)
	if err != nil {
		return nil, errors.Join(err, server.Close())
	}
	g := &Gateway{server: server, listener: listener, errors: make(chan error, 2)}
	g.public = newServer(metrics.Observe(handler, log))
	if options.ListenTLS.Empty() {
		go func() { g.errors <- g.public.Serve(listener) }()
	} else {
		files, err := certificates.Load(options.ListenTLS, log)
		if err != nil {
			return nil, errors.Join(err, g.Stop(ctx))
		}
		g.public.TLSConfig = files.ForServing()
		go func() { g.errors <- g.public.ServeTLS(listener, "", "") }()
	}
	if options.MetricsListen != "" {
		if err := g.serveMetrics(options.MetricsListen, metrics); err != nil {
			return nil, errors.Join(err, g.Stop(ctx))
		}
	}
	return g, nil
}

// A socket in the file system needs no TLS.
func credentialsFor(options Options, log *slog.Logger) (credentials.TransportCredentials, error) {
	if options.ServerTLS.Empty() || strings.HasPrefix(options.Server, "unix:") {
		return insecure.NewCredentials(), nil
	}
	if options.ServerTLS.Authorities == "" {
		return nil, errors.New("TLS to enfilade-server needs the authorities whose servers are trusted")
	}
	files, err := certificates.Load(options.ServerTLS, log)
	if err != nil {
		return nil, err
	}
	return credentials.NewTLS(files.ForCalling()), nil
}

func newServer(handler http.Handler) *http.Server {
	// No WriteTimeout: it would cut streams. The guard gives each write a deadline.
	return &http.Server{Handler: handler, ReadHeaderTimeout: 5 * time.Second, IdleTimeout: 2 * time.Minute,
		MaxHeaderBytes: 16 << 10, ErrorLog: slog.NewLogLogger(slog.Default().Handler(), slog.LevelWarn)}
}

func (g *Gateway) serveMetrics(address string, metrics *telemetry.Metrics) error {
	listener, err := net.Listen("tcp", address)
	if err != nil {
		return err
	}
	mux := http.NewServeMux()
	mux.Handle("GET /metrics", metrics.Handler())
	g.metrics = newServer(mux)
	go func() { g.errors <- g.metrics.Serve(listener) }()
	return nil
}

func newHandler(ctx context.Context, server *grpc.ClientConn, metrics *telemetry.Metrics,
	options Options) (http.Handler, error) {
	api, err := rest.NewMux(ctx, server)
	if err != nil {
		return nil, err
	}
	if err := files.Register(api, server, options.Uploads); err != nil {
		return nil, err
	}
	if err := rasters.Register(api, server); err != nil {
		return nil, err
	}
	if err := vectors.Register(api, server); err != nil {
		return nil, err
	}
	pages, err := dashboard.Handler()
	if err != nil {
		return nil, err
	}
	docs, err := reference.Handler()
	if err != nil {
		return nil, err
	}
	mux := http.NewServeMux()
	mux.Handle("/v1/", rest.Resume(api))
	mux.Handle(reference.Path, docs)
	mux.Handle(reference.Path+"/", docs)
	mux.HandleFunc("GET /openapi.json", openapi.Serve)
	mux.HandleFunc("GET /healthz", func(w http.ResponseWriter, _ *http.Request) { _, _ = fmt.Fprintln(w, "ok") })
	mux.HandleFunc("GET /readyz", readiness(grpc_health_v1.NewHealthClient(server)))
	mux.HandleFunc("GET /statusz", metrics.ServeStatus)
	mux.Handle("/", pages)
	return guard.Wrap(mux, options.Hosts, options.Origins, options.Limits)
}

// A call must end, whatever becomes of the server.
func limitTime(limit time.Duration) grpc.UnaryClientInterceptor {
	return func(ctx context.Context, method string, request, reply any, connection *grpc.ClientConn,
		invoke grpc.UnaryInvoker, options ...grpc.CallOption) error {
		ctx, cancel := context.WithTimeout(ctx, limit)
		defer cancel()
		return invoke(ctx, method, request, reply, connection, options...)
	}
}

// Ready if the server is: load balancers and dashboards ask.
func readiness(health grpc_health_v1.HealthClient) http.HandlerFunc {
	return func(w http.ResponseWriter, r *http.Request) {
		ctx, cancel := context.WithTimeout(r.Context(), 2*time.Second)
		defer cancel()
		response, err := health.Check(ctx, &grpc_health_v1.HealthCheckRequest{})
		if err != nil || response.GetStatus() != grpc_health_v1.HealthCheckResponse_SERVING {
			w.Header().Set("Retry-After", "1")
			rest.WriteStatus(w, http.StatusServiceUnavailable, codes.Unavailable, "the map server is not ready")
			return
		}
		_, _ = fmt.Fprintln(w, "ready")
	}
}

// Addr is where the gateway listens.
func (g *Gateway) Addr() string { return g.listener.Addr().String() }

// Errors has the reason if the gateway ends by itself.
func (g *Gateway) Errors() <-chan error { return g.errors }

// Stop ends streams and waits for other requests until `ctx` ends.
func (g *Gateway) Stop(ctx context.Context) error {
	err := g.server.Close() // ends the streams
	err = errors.Join(err, g.public.Shutdown(ctx))
	if g.metrics != nil {
		err = errors.Join(err, g.metrics.Close())
	}
	return err
}
