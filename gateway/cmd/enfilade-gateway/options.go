// SPDX-License-Identifier: Apache-2.0

package main

import (
	"errors"
	"flag"
	"fmt"
	"net"
	"os"
	"strings"
	"time"

	"enfilade/gateway/internal/app"
	"enfilade/gateway/internal/files"
	"enfilade/gateway/internal/guard"
)

// version is set by the build.
var version = "unknown"

const environmentPrefix = "ENFILADE_GATEWAY_"

// names is a flag that may be given several times, or with commas between the names.
type names []string

func (n *names) String() string { return strings.Join(*n, ",") }
func (n *names) Set(list string) error {
	*n = append(*n, strings.Split(list, ",")...)
	return nil
}

// otherWork is what the command line asks for instead of serving.
type otherWork struct{ version, manual, probe bool }

type settings struct {
	app.Options
	insecure bool
	other    otherWork
}

func defaults() settings {
	return settings{Options: app.Options{Limits: guard.DefaultLimits(), Uploads: files.DefaultUploadLimits()}}
}

func flagsOf(s *settings) *flag.FlagSet {
	options := &s.Options
	flags := flag.NewFlagSet("enfilade-gateway", flag.ContinueOnError)
	flags.StringVar(&options.Listen, "listen", "127.0.0.1:8080", "address to listen on; port 0 takes a free one")
	flags.StringVar(&options.MetricsListen, "metrics", "127.0.0.1:9465", "address of the metrics; empty: none")
	flags.StringVar(&options.Server, "server", "localhost:50051", "enfilade-server: host:port or unix:PATH")
	flags.StringVar(&options.ServerTLS.Authorities, "server-tls-authorities", "", "PEM file: whose word is taken for who enfilade-server is; calls it by TLS")
	flags.StringVar(&options.ServerTLS.Certificate, "server-tls-certificate", "", "PEM file: the gateway's own certificate, if enfilade-server asks for one")
	flags.StringVar(&options.ServerTLS.Key, "server-tls-key", "", "PEM file: its key")
	flags.StringVar(&options.ListenTLS.Certificate, "tls-certificate", "", "PEM file: serves by TLS with this certificate")
	flags.StringVar(&options.ListenTLS.Key, "tls-key", "", "PEM file: its key")
	flags.BoolVar(&s.insecure, "insecure", false, "serve other machines without TLS")
	flags.DurationVar(&options.CallTime, "call-time", 30*time.Second, "for a call that is no stream")
	flags.Var((*names)(&options.Hosts), "host", "a host name that clients may call this gateway by, besides localhost; repeatable")
	flags.Var((*names)(&options.Origins), "origin", "an origin whose pages may change things, such as https://maps.example.org; repeatable")
	rates := &options.Limits.Rates
	flags.Float64Var(&rates.CallsPerSecond, "calls-per-second", rates.CallsPerSecond, "of one address, with bursts of 4 s; 0: any number")
	flags.Float64Var(&rates.TilesPerSecond, "tiles-per-second", rates.TilesPerSecond, "requests of tiles of one address, with bursts of 4 s; 0: any number")
	flags.IntVar(&rates.Exports, "exports", rates.Exports, "of one address at once; 0: any number")
	flags.BoolVar(&s.other.probe, "probe", false, "ask the gateway at the address of --listen whether it is ready, and exit: 0 if it is")
	flags.BoolVar(&s.other.manual, "print-manual", false, "print the manual page, for man(7), and exit")
	flags.BoolVar(&s.other.version, "version", false, "print the version and exit")
	flags.Usage = func() {
		fmt.Fprintln(flags.Output(), "Enfilade's API over HTTP, and the dashboard.\nUsage: enfilade-gateway [OPTIONS]\n\nOptions:")
		flags.VisitAll(func(f *flag.Flag) {
			value, usage := valueOf(f)
			fmt.Fprintf(flags.Output(), "  --%s %s\n        %s\n", f.Name, value, usage)
		})
	}
	return flags
}

// valueOf tells what the flag's value is called, and what it does, with its default.
func valueOf(f *flag.Flag) (value, usage string) {
	value, usage = flag.UnquoteUsage(f)
	if f.DefValue != "" && f.DefValue != "false" {
		usage += fmt.Sprintf(" (default: %s)", f.DefValue)
	}
	return strings.ToUpper(value), usage
}

// environmentOf is the variable that sets a flag: ENFILADE_GATEWAY_TLS_KEY for --tls-key.
func environmentOf(name string) string {
	return environmentPrefix + strings.ToUpper(strings.ReplaceAll(name, "-", "_"))
}

func applyEnvironment(flags *flag.FlagSet, environment []string) error {
	known := map[string]string{}
	flags.VisitAll(func(f *flag.Flag) { known[environmentOf(f.Name)] = f.Name })
	for _, variable := range environment {
		name, value, _ := strings.Cut(variable, "=")
		if !strings.HasPrefix(name, environmentPrefix) {
			continue
		}
		option, found := known[name]
		if !found {
			return fmt.Errorf("%s: there is no option of that name", name)
		}
		if err := flags.Set(option, value); err != nil {
			return fmt.Errorf("%s: %w", name, err)
		}
	}
	return nil
}

// parse reads the environment, then the arguments, which win.
func parse(arguments, environment []string) (settings, error) {
	s := defaults()
	flags := flagsOf(&s)
	if err := applyEnvironment(flags, environment); err != nil {
		return s, err
	}
	if err := flags.Parse(arguments); err != nil {
		return s, err
	}
	if flags.NArg() > 0 {
		return s, fmt.Errorf("unexpected argument %q", flags.Arg(0))
	}
	if s.other.version || s.other.manual {
		return s, nil
	}
	return s, s.check()
}

func (s *settings) check() error {
	host, _, err := net.SplitHostPort(s.Listen)
	if err != nil {
		return fmt.Errorf("--listen: %w", err)
	}
	address := net.ParseIP(host)
	local := (address != nil && address.IsLoopback()) || host == "localhost"
	if !local && len(s.Hosts) == 0 {
		return errors.New("--listen is not local: say by --host under which names clients call the gateway")
	}
	if !local && s.ListenTLS.Empty() && !s.insecure {
		return errors.New("--listen is not local, and there is no TLS: give --tls-certificate and --tls-key, or" +
			" --insecure if the network is yours alone, or a proxy before the gateway speaks TLS")
	}
	s.Hosts = append(s.Hosts, "localhost", "127.0.0.1", "::1")
	return nil
}

func fromCommandLine() (settings, error) { return parse(os.Args[1:], os.Environ()) }
