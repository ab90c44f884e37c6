// SPDX-License-Identifier: Apache-2.0

// Command enfilade-gateway serves Enfilade's API over HTTP: REST with JSON, server-sent events and files.
package main

import (
	"context"
	"crypto/tls"
	"errors"
	"flag"
	"fmt"
	"log/slog"
	"net"
	"net/http"
	"os"
	"os/signal"
	"syscall"
	"time"

	"github.com/coreos/go-systemd/v22/daemon"

	"enfilade/gateway/internal/app"
)

func main() {
	if err := run(); err != nil && !errors.Is(err, flag.ErrHelp) {
		fmt.Fprintln(os.Stderr, "enfilade-gateway:", err)
		os.Exit(1)
	}
}

func run() error {
	settings, err := fromCommandLine()
	if err != nil {
		return err
	}
	switch {
	case settings.other.version:
		fmt.Println(version)
		return nil
	case settings.other.manual:
		fmt.Print(manual())
		return nil
	case settings.other.probe:
		return probe(settings.Options)
	}
	return serve(settings.Options)
}

func serve(options app.Options) error {
	log := slog.New(slog.NewJSONHandler(os.Stderr, nil))
	slog.SetDefault(log)
	ctx, stop := signal.NotifyContext(context.Background(), os.Interrupt, syscall.SIGTERM)
	defer stop()
	gateway, err := app.Start(ctx, options, log)
	if err != nil {
		return err
	}
	log.Info("listening", "address", gateway.Addr(), "server", options.Server)
	notify(daemon.SdNotifyReady)
	select {
	case err = <-gateway.Errors():
	case <-ctx.Done():
		log.Info("stopping")
	}
	notify(daemon.SdNotifyStopping)
	patience, cancel := context.WithTimeout(context.Background(), 10*time.Second)
	defer cancel()
	return errors.Join(err, gateway.Stop(patience))
}

// notify tells systemd, if it runs the gateway as a service of Type=notify.
func notify(state string) { _, _ = daemon.SdNotify(false, state) }

// probe asks the gateway of these options whether it and the server behind it are ready.
func probe(options app.Options) error {
	_, port, _ := net.SplitHostPort(options.Listen)
	scheme, transport := "http", http.DefaultTransport.(*http.Transport).Clone()
	transport.Proxy = nil
	if !options.ListenTLS.Empty() {
		// Whether the port answers is asked, of this machine itself: the certificate names the hosts of others.
		scheme, transport.TLSClientConfig = "https", &tls.Config{InsecureSkipVerify: true}
	}
	client := http.Client{Transport: transport, Timeout: 5 * time.Second}
	answer, err := client.Get(fmt.Sprintf("%s://localhost:%s/readyz", scheme, port))
	if err != nil {
		return err
	}
	defer answer.Body.Close()
	if answer.StatusCode != http.StatusOK {
		return fmt.Errorf("not ready: %s", answer.Status)
	}
	return nil
}
