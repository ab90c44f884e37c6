// SPDX-License-Identifier: Apache-2.0

// Package certificates reads TLS files, and reads them again when they change. A file that is broken changes nothing: the last
// good set stays.
package certificates

import (
	"crypto/tls"
	"crypto/x509"
	"errors"
	"fmt"
	"log/slog"
	"os"
	"strings"
	"sync"
	"time"
)

// Files in PEM format. Certificate and key go together; either pair or authorities may be empty.
type Files struct {
	Certificate string // its own, with those of the authorities between it and the root
	Key         string
	Authorities string // whose word is taken for who the other side is
}

// Empty says that there are none.
func (f Files) Empty() bool { return f == Files{} }

const lookEvery = time.Second

// Of TLS 1.2: those that encrypt and authenticate at once. Those of 1.3 all do.
var suites = []uint16{tls.TLS_ECDHE_ECDSA_WITH_AES_128_GCM_SHA256, tls.TLS_ECDHE_ECDSA_WITH_AES_256_GCM_SHA384,
	tls.TLS_ECDHE_ECDSA_WITH_CHACHA20_POLY1305_SHA256, tls.TLS_ECDHE_RSA_WITH_AES_128_GCM_SHA256,
	tls.TLS_ECDHE_RSA_WITH_AES_256_GCM_SHA384, tls.TLS_ECDHE_RSA_WITH_CHACHA20_POLY1305_SHA256}

// Set is the last good content of the files.
type Set struct {
	files Files
	log   *slog.Logger

	mutex       sync.Mutex
	looked      time.Time
	state       string // of the files that have been read
	certificate *tls.Certificate
	authorities *x509.CertPool
}

// Load reads the files; an error says which one is wrong.
func Load(files Files, log *slog.Logger) (*Set, error) {
	if (files.Certificate == "") != (files.Key == "") {
		return nil, errors.New("a certificate and its key go together")
	}
	s := &Set{files: files, log: log}
	if err := s.read(); err != nil {
		return nil, err
	}
	return s, nil
}

func (s *Set) read() error {
	s.looked, s.state = time.Now(), s.stateOfFiles()
	var certificate *tls.Certificate
	if s.files.Certificate != "" {
		pair, err := tls.LoadX509KeyPair(s.files.Certificate, s.files.Key)
		if err != nil {
			return fmt.Errorf("%s, %s: %w", s.files.Certificate, s.files.Key, err)
		}
		if time.Now().After(pair.Leaf.NotAfter) {
			return fmt.Errorf("%s is no longer valid", s.files.Certificate)
		}
		certificate = &pair
	}
	var authorities *x509.CertPool
	if s.files.Authorities != "" {
		pem, err := os.ReadFile(s.files.Authorities)
		if err != nil {
			return err
		}
		authorities = x509.NewCertPool()
		if !authorities.AppendCertsFromPEM(pem) {
			return fmt.Errorf("%s has no certificate in PEM format", s.files.Authorities)
		}
	}
	s.certificate, s.authorities = certificate, authorities
	return nil
}

// stateOfFiles changes when a file does, also to an older one.
func (s *Set) stateOfFiles() string {
	var state strings.Builder
	for _, path := range []string{s.files.Certificate, s.files.Key, s.files.Authorities} {
		if info, err := os.Stat(path); err == nil {
			fmt.Fprintf(&state, "%d %d;", info.ModTime().UnixNano(), info.Size())
		}
	}
	return state.String()
}

func (s *Set) current() (*tls.Certificate, *x509.CertPool) {
	s.mutex.Lock()
	defer s.mutex.Unlock()
	if time.Since(s.looked) >= lookEvery {
		s.looked = time.Now()
		if s.stateOfFiles() != s.state {
			if err := s.read(); err != nil {
				s.log.Error("the TLS files have changed, and are not used", "error", err.Error())
			}
		}
	}
	return s.certificate, s.authorities
}

// ForServing answers with the certificate.
func (s *Set) ForServing() *tls.Config {
	return &tls.Config{MinVersion: tls.VersionTLS12, CipherSuites: suites,
		GetCertificate: func(*tls.ClientHelloInfo) (*tls.Certificate, error) {
			certificate, _ := s.current()
			return certificate, nil
		}}
}

// ForCalling shows the certificate, if there is one, and trusts the authorities only.
func (s *Set) ForCalling() *tls.Config {
	return &tls.Config{
		MinVersion:   tls.VersionTLS12,
		CipherSuites: suites,
		GetClientCertificate: func(*tls.CertificateRequestInfo) (*tls.Certificate, error) {
			certificate, _ := s.current()
			if certificate == nil {
				certificate = &tls.Certificate{}
			}
			return certificate, nil
		},
		// Verified below: the pool of a configuration cannot change.
		InsecureSkipVerify: true, //nolint:gosec
		VerifyConnection: func(state tls.ConnectionState) error {
			_, authorities := s.current()
			between := x509.NewCertPool()
			for _, certificate := range state.PeerCertificates[1:] {
				between.AddCert(certificate)
			}
			_, err := state.PeerCertificates[0].Verify(x509.VerifyOptions{
				Roots: authorities, Intermediates: between, DNSName: state.ServerName})
			return err
		},
	}
}
