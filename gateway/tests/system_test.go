// SPDX-License-Identifier: Apache-2.0

// Package tests runs the gateway against a real server with a real database.
package tests

import (
	"bytes"
	"context"
	"encoding/json"
	"fmt"
	"io"
	"log/slog"
	"net"
	"net/http"
	"os"
	"os/exec"
	"path/filepath"
	"strings"
	"sync"
	"sync/atomic"
	"syscall"
	"testing"
	"time"

	"google.golang.org/grpc"
	"google.golang.org/grpc/credentials/insecure"

	"enfilade/gateway/internal/app"
	"enfilade/gateway/internal/files"
	"enfilade/gateway/internal/guard"
)

// system is a database, a server and a gateway of the tests' own.
type system struct {
	folder   string
	database string // its URL
	server   *exec.Cmd
	address  string // of the server
	metrics  string // of the server, for Prometheus
	gateway  *app.Gateway
	url      string // of the gateway
	log      lockedBuffer
	direct   *grpc.ClientConn
}

type lockedBuffer struct {
	mutex  sync.Mutex
	buffer bytes.Buffer
}

func (b *lockedBuffer) Write(content []byte) (int, error) {
	b.mutex.Lock()
	defer b.mutex.Unlock()
	return b.buffer.Write(content)
}

func (b *lockedBuffer) String() string {
	b.mutex.Lock()
	defer b.mutex.Unlock()
	return b.buffer.String()
}

var shared *system

// TestMain starts the one system that the tests share; each test has a site of its own.
func TestMain(m *testing.M) {
	binaries := os.Getenv("ENFILADE_BIN")
	if binaries == "" {
		fmt.Println("skipped: ENFILADE_BIN does not name the folder of enfilade-server")
		os.Exit(0)
	}
	s, err := start(binaries)
	code := 1
	if err != nil {
		fmt.Println("cannot start:", err)
	} else {
		shared = s
		code = m.Run()
	}
	s.stop()
	os.Exit(code)
}

func project(path string) string {
	root, _ := filepath.Abs("../..")
	return filepath.Join(root, path)
}

func start(binaries string) (*system, error) {
	folder, err := os.MkdirTemp("", "enfilade-gateway-")
	if err != nil {
		return nil, err
	}
	s := &system{folder: folder, address: "unix:" + folder + "/server.sock"}
	if err := os.Chmod(folder, 0o755); err != nil { // the database's owner enters it
		return s, err
	}
	url, err := exec.Command(project("deploy/database/cluster"), "start", folder+"/database").Output()
	if err != nil {
		return s, err
	}
	s.database = strings.TrimSpace(string(url))
	if out, err := exec.Command(project("deploy/database/migrate"), "up", s.database).CombinedOutput(); err != nil {
		return s, fmt.Errorf("%w: %s", err, out)
	}
	if err := s.startServer(binaries); err != nil {
		return s, err
	}
	limits := guard.DefaultLimits()
	limits.Rates = guard.Rates{} // the tests are one client; limits_test.go has gateways with rates
	options := app.Options{Listen: "127.0.0.1:0", Server: s.address, Hosts: []string{"127.0.0.1", "localhost"},
		CallTime: 30 * time.Second, Limits: limits, Uploads: files.DefaultUploadLimits()}
	log := slog.New(slog.NewJSONHandler(&s.log, nil))
	slog.SetDefault(log)
	if s.gateway, err = app.Start(context.Background(), options, log); err != nil {
		return s, err
	}
	s.url = "http://" + s.gateway.Addr()
	s.direct, err = grpc.NewClient(s.address, grpc.WithTransportCredentials(insecure.NewCredentials()))
	if err != nil {
		return s, err
	}
	return s, s.awaitReady()
}

func (s *system) startServer(binaries string) error {
	log, err := os.Create(s.folder + "/server.log")
	if err != nil {
		return err
	}
	defer log.Close()
	free, err := net.Listen("tcp", "127.0.0.1:0")
	if err != nil {
		return err
	}
	s.metrics = free.Addr().String()
	_ = free.Close()
	s.server = exec.Command(filepath.Join(binaries, "enfilade-server"), "--set", "listen.address="+s.address,
		"--set", "metrics.address="+s.metrics, "--set", "transfers.cache_directory="+s.folder)
	s.server.Env = append(os.Environ(), "ENFILADE_SERVER_DATABASE_URL="+s.database)
	s.server.Stdout, s.server.Stderr = log, log
	s.server.SysProcAttr = &syscall.SysProcAttr{Pdeathsig: syscall.SIGKILL}
	return s.server.Start()
}

func (s *system) awaitReady() error {
	for range 300 {
		response, err := http.Get(s.url + "/readyz")
		if err == nil {
			response.Body.Close()
			if response.StatusCode == http.StatusOK {
				return nil
			}
		}
		time.Sleep(100 * time.Millisecond)
	}
	return fmt.Errorf("the server is not ready")
}

func (s *system) stopServer() {
	if s.server != nil && s.server.Process != nil {
		_ = s.server.Process.Kill()
		_ = s.server.Wait()
	}
}

func (s *system) stop() {
	if s == nil {
		return
	}
	if s.direct != nil {
		_ = s.direct.Close()
	}
	if s.gateway != nil {
		ctx, cancel := context.WithTimeout(context.Background(), 10*time.Second)
		_ = s.gateway.Stop(ctx)
		cancel()
	}
	s.stopServer()
	_ = exec.Command(project("deploy/database/cluster"), "stop", s.folder+"/database").Run()
	_ = os.RemoveAll(s.folder)
}

// answer of the gateway, read to its end.
type answer struct {
	status int
	header http.Header
	body   []byte
}

func (a answer) json(t *testing.T) map[string]any {
	t.Helper()
	var value map[string]any
	if err := json.Unmarshal(a.body, &value); err != nil {
		t.Fatalf("no JSON (status %d): %s", a.status, a.body)
	}
	return value
}

type header map[string]string

// call sends a request; `body` nil: none.
func call(t *testing.T, method, path string, body io.Reader, headers header) answer {
	t.Helper()
	request, err := http.NewRequest(method, shared.url+path, body)
	if err != nil {
		t.Fatal(err)
	}
	for name, value := range headers {
		if name == "Host" {
			request.Host = value
		} else {
			request.Header.Set(name, value)
		}
	}
	response, err := http.DefaultTransport.RoundTrip(request)
	if err != nil {
		t.Fatal(err)
	}
	defer response.Body.Close()
	content, err := io.ReadAll(response.Body)
	if err != nil {
		t.Fatal(err)
	}
	return answer{response.StatusCode, response.Header, content}
}

// must sends JSON and expects 200.
func must(t *testing.T, method, path, body string) map[string]any {
	t.Helper()
	got := call(t, method, path, strings.NewReader(body), header{"Content-Type": "application/json"})
	if got.status != http.StatusOK {
		t.Fatalf("%s %s: status %d: %s", method, path, got.status, got.body)
	}
	return got.json(t)
}

var sites atomic.Int32

// newSite makes a site of the test's own, with a robot and a map; returns its resource name.
func newSite(t *testing.T) string {
	t.Helper()
	id := fmt.Sprintf("test%d", sites.Add(1))
	must(t, "POST", "/v1/sites?siteId="+id, `{"displayName": "Test"}`)
	must(t, "POST", "/v1/sites/"+id+"/robots?robotId=r1", `{"displayName": "One"}`)
	must(t, "POST", "/v1/sites/"+id+"/maps?mapId=hall", `{"displayName": "Hall"}`)
	return "sites/" + id
}
