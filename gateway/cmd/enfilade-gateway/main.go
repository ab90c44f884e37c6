// SPDX-License-Identifier: Apache-2.0

// Command enfilade-gateway serves Enfilade's API over HTTP: REST with JSON, server-sent events and files.
package main

import (
	"context"
	"errors"
	"flag"
	"fmt"
	"log/slog"
	"net"
	"os"
	"os/signal"
	"strings"
	"syscall"
	"time"

	"enfilade/gateway/internal/app"
	"enfilade/gateway/internal/files"
	"enfilade/gateway/internal/guard"
)

// names is a flag that may be given several times.
type names []string

func (n *names) String() string { return strings.Join(*n, ",") }
func (n *names) Set(name string) error {
	*n = append(*n, name)
	return nil
}

func main() {
	if err := run(os.Args[1:]); err != nil && !errors.Is(err, flag.ErrHelp) {
		fmt.Fprintln(os.Stderr, "enfilade-gateway:", err)
		os.Exit(1)
	}
}

func parse(arguments []string) (app.Options, error) {
	options := app.Options{Limits: guard.DefaultLimits(), Uploads: files.DefaultUploadLimits()}
	flags := flag.NewFlagSet("enfilade-gateway", flag.ContinueOnError)
	flags.StringVar(&options.Listen, "listen", "127.0.0.1:8080", "address to listen on; port 0 takes a free one")
	flags.StringVar(&options.MetricsListen, "metrics", "127.0.0.1:9465", "address of the metrics; empty: none")
	flags.StringVar(&options.Server, "server", "localhost:50051", "enfilade-server: host:port or unix:PATH")
	flags.StringVar(&options.ServerTLS.Authorities, "server-tls-authorities", "", "PEM file: whose word is taken for who enfilade-server is; calls it by TLS")
	flags.StringVar(&options.ServerTLS.Certificate, "server-tls-certificate", "", "PEM file: the gateway's own certificate, if enfilade-server asks for one")
	flags.StringVar(&options.ServerTLS.Key, "server-tls-key", "", "PEM file: its key")
	flags.StringVar(&options.ListenTLS.Certificate, "tls-certificate", "", "PEM file: serves by TLS with this certificate")
	flags.StringVar(&options.ListenTLS.Key, "tls-key", "", "PEM file: its key")
	insecure := flags.Bool("insecure", false, "serve other machines without TLS")
	flags.DurationVar(&options.CallTime, "call-time", 30*time.Second, "for a call that is no stream")
	flags.Var((*names)(&options.Hosts), "host", "a host name that clients may call this gateway by, besides localhost; repeatable")
	flags.Var((*names)(&options.Origins), "origin", "an origin whose pages may change things, such as https://maps.example.org; repeatable")
	rates := &options.Limits.Rates
	flags.Float64Var(&rates.CallsPerSecond, "calls-per-second", rates.CallsPerSecond, "of one address, with bursts of 4 s; 0: any number")
	flags.Float64Var(&rates.TilesPerSecond, "tiles-per-second", rates.TilesPerSecond, "requests of tiles of one address, with bursts of 4 s; 0: any number")
	flags.IntVar(&rates.Exports, "exports", rates.Exports, "of one address at once; 0: any number")
	if err := flags.Parse(arguments); err != nil {
		return options, err
	}
	if flags.NArg() > 0 {
		return options, fmt.Errorf("unexpected argument %q", flags.Arg(0))
	}
	host, _, err := net.SplitHostPort(options.Listen)
	if err != nil {
		return options, fmt.Errorf("--listen: %w", err)
	}
	address := net.ParseIP(host)
	local := (address != nil && address.IsLoopback()) || host == "localhost"
	if !local && len(options.Hosts) == 0 {
		return options, errors.New("--listen is not local: say by --host under which names clients call the gateway")
	}
	if !local && options.ListenTLS.Empty() && !*insecure {
		return options, errors.New("--listen is not local, and there is no TLS: give --tls-certificate and --tls-key, or" +
			" --insecure if the network is yours alone, or a proxy before the gateway speaks TLS")
	}
	options.Hosts = append(options.Hosts, "localhost", "127.0.0.1", "::1")
	return options, nil
}

func run(arguments []string) error {
	options, err := parse(arguments)
	if err != nil {
		return err
	}
	log := slog.New(slog.NewJSONHandler(os.Stderr, nil))
	slog.SetDefault(log)
	ctx, stop := signal.NotifyContext(context.Background(), os.Interrupt, syscall.SIGTERM)
	defer stop()
	gateway, err := app.Start(ctx, options, log)
	if err != nil {
		return err
	}
	log.Info("listening", "address", gateway.Addr(), "server", options.Server)
	select {
	case err = <-gateway.Errors():
	case <-ctx.Done():
		log.Info("stopping")
	}
	patience, cancel := context.WithTimeout(context.Background(), 10*time.Second)
	defer cancel()
	return errors.Join(err, gateway.Stop(patience))
}
