// SPDX-License-Identifier: Apache-2.0

package certificates

import (
	"crypto/ecdsa"
	"crypto/elliptic"
	"crypto/rand"
	"crypto/tls"
	"crypto/x509"
	"crypto/x509/pkix"
	"encoding/pem"
	"io"
	"log/slog"
	"math/big"
	"net"
	"os"
	"path/filepath"
	"testing"
	"time"
)

// authority issues certificates for localhost.
type authority struct {
	certificate *x509.Certificate
	key         *ecdsa.PrivateKey
}

func newAuthority(t *testing.T) authority {
	t.Helper()
	key, err := ecdsa.GenerateKey(elliptic.P256(), rand.Reader)
	if err != nil {
		t.Fatal(err)
	}
	template := &x509.Certificate{SerialNumber: big.NewInt(1), Subject: pkix.Name{CommonName: "authority"},
		NotBefore: time.Now().Add(-time.Hour), NotAfter: time.Now().Add(time.Hour), IsCA: true,
		BasicConstraintsValid: true, KeyUsage: x509.KeyUsageCertSign}
	der, err := x509.CreateCertificate(rand.Reader, template, template, &key.PublicKey, key)
	if err != nil {
		t.Fatal(err)
	}
	certificate, _ := x509.ParseCertificate(der)
	return authority{certificate, key}
}

func write(t *testing.T, path, kind string, der []byte) string {
	t.Helper()
	if err := os.WriteFile(path, pem.EncodeToMemory(&pem.Block{Type: kind, Bytes: der}), 0o600); err != nil {
		t.Fatal(err)
	}
	return path
}

// issue writes a certificate, its key and the authority to the folder.
func (a authority) issue(t *testing.T, folder string) Files {
	t.Helper()
	key, err := ecdsa.GenerateKey(elliptic.P256(), rand.Reader)
	if err != nil {
		t.Fatal(err)
	}
	template := &x509.Certificate{SerialNumber: big.NewInt(2), Subject: pkix.Name{CommonName: "localhost"},
		NotBefore: time.Now().Add(-time.Hour), NotAfter: time.Now().Add(time.Hour), DNSNames: []string{"localhost"}}
	der, err := x509.CreateCertificate(rand.Reader, template, a.certificate, &key.PublicKey, a.key)
	if err != nil {
		t.Fatal(err)
	}
	private, _ := x509.MarshalPKCS8PrivateKey(key)
	return Files{Certificate: write(t, filepath.Join(folder, "certificate.pem"), "CERTIFICATE", der),
		Key:         write(t, filepath.Join(folder, "key.pem"), "PRIVATE KEY", private),
		Authorities: write(t, filepath.Join(folder, "authorities.pem"), "CERTIFICATE", a.certificate.Raw)}
}

func load(t *testing.T, files Files) *Set {
	t.Helper()
	set, err := Load(files, slog.New(slog.NewJSONHandler(io.Discard, nil)))
	if err != nil {
		t.Fatal(err)
	}
	return set
}

// handshake connects a client to a server, each with its configuration.
func handshake(t *testing.T, serving, calling *tls.Config) error {
	t.Helper()
	listener, err := tls.Listen("tcp", "127.0.0.1:0", serving)
	if err != nil {
		t.Fatal(err)
	}
	defer listener.Close()
	go func() {
		if connection, err := listener.Accept(); err == nil {
			_ = connection.(*tls.Conn).Handshake()
			connection.Close()
		}
	}()
	calling.ServerName = "localhost"
	connection, err := tls.DialWithDialer(&net.Dialer{Timeout: 10 * time.Second}, "tcp", listener.Addr().String(), calling)
	if err == nil {
		connection.Close()
	}
	return err
}

func TestACallerTrustsItsAuthoritiesOnly(t *testing.T) {
	ours, others := newAuthority(t), newAuthority(t)
	server := load(t, ours.issue(t, t.TempDir()))
	if err := handshake(t, server.ForServing(), load(t, ours.issue(t, t.TempDir())).ForCalling()); err != nil {
		t.Error(err)
	}
	if err := handshake(t, server.ForServing(), load(t, others.issue(t, t.TempDir())).ForCalling()); err == nil {
		t.Error("the server of another authority is trusted")
	}
}

func TestOldVersionsAndWeakSuitesAreRefused(t *testing.T) {
	ours := newAuthority(t)
	server := load(t, ours.issue(t, t.TempDir()))
	for name, weaken := range map[string]func(*tls.Config){
		"TLS 1.1": func(c *tls.Config) { c.MinVersion, c.MaxVersion = tls.VersionTLS10, tls.VersionTLS11 },
		"a suite with CBC": func(c *tls.Config) {
			c.MaxVersion = tls.VersionTLS12
			c.CipherSuites = []uint16{tls.TLS_ECDHE_ECDSA_WITH_AES_128_CBC_SHA}
		}} {
		calling := load(t, ours.issue(t, t.TempDir())).ForCalling()
		weaken(calling)
		if err := handshake(t, server.ForServing(), calling); err == nil {
			t.Errorf("%s is accepted", name)
		}
	}
}

func TestChangedFilesAreUsedAndBrokenOnesAreNot(t *testing.T) {
	before, after := newAuthority(t), newAuthority(t)
	folder := t.TempDir()
	files := before.issue(t, folder)
	server := load(t, files)
	ofBefore := load(t, before.issue(t, t.TempDir()))
	ofAfter := load(t, after.issue(t, t.TempDir()))
	look := func() { server.looked = time.Time{} } // instead of waiting for a second
	if err := os.WriteFile(files.Key, []byte("no key"), 0o600); err != nil {
		t.Fatal(err)
	}
	look()
	if err := handshake(t, server.ForServing(), ofBefore.ForCalling()); err != nil {
		t.Errorf("with a broken key: %v", err)
	}
	after.issue(t, folder)
	look()
	if err := handshake(t, server.ForServing(), ofAfter.ForCalling()); err != nil {
		t.Errorf("with new files: %v", err)
	}
}

func TestFilesThatAreWrongAreRefusedAtTheStart(t *testing.T) {
	files := newAuthority(t).issue(t, t.TempDir())
	other := newAuthority(t).issue(t, t.TempDir())
	for name, wrong := range map[string]Files{"no key": {Certificate: files.Certificate},
		"the key of another": {Certificate: files.Certificate, Key: other.Key}, "no such file": {Authorities: "/nowhere"},
		"no certificate": {Authorities: files.Key}} {
		if _, err := Load(wrong, slog.Default()); err == nil {
			t.Errorf("%s: accepted", name)
		}
	}
}
