// SPDX-License-Identifier: Apache-2.0

// Command convert turns the OpenAPI 2 document of protoc-gen-openapiv2, which alone reads proto/gateway.yaml, into the
// OpenAPI 3 document that the gateway serves. FILES describes the addresses that are no RPCs. usage: convert IN FILES OUT
package main

import (
	"context"
	"encoding/json"
	"fmt"
	"os"

	"github.com/getkin/kin-openapi/openapi2"
	"github.com/getkin/kin-openapi/openapi2conv"
	"github.com/getkin/kin-openapi/openapi3"
	"go.yaml.in/yaml/v3"
)

func main() {
	if err := convert(os.Args[1], os.Args[2], os.Args[3]); err != nil {
		fmt.Fprintln(os.Stderr, "convert:", err)
		os.Exit(1)
	}
}

func convert(in, files, out string) error {
	content, err := os.ReadFile(in)
	if err != nil {
		return err
	}
	var two openapi2.T
	if err := json.Unmarshal(content, &two); err != nil {
		return err
	}
	three, err := openapi2conv.ToV3(&two)
	if err != nil {
		return err
	}
	rpcs, err := json.Marshal(three)
	if err != nil {
		return err
	}
	merged, err := addFiles(rpcs, files)
	if err != nil {
		return err
	}
	document, err := openapi3.NewLoader().LoadFromData(merged)
	if err != nil {
		return err
	}
	if err := mend(document); err != nil {
		return err
	}
	encoded, err := json.MarshalIndent(document, "", " ")
	if err != nil {
		return err
	}
	// As others will: with its references resolved anew.
	if document, err = openapi3.NewLoader().LoadFromData(encoded); err != nil {
		return err
	}
	if err := document.Validate(context.Background()); err != nil {
		return err
	}
	return os.WriteFile(out, encoded, 0o644)
}

// addFiles puts what the YAML file says into the document: its title, and its tags, paths and components behind those
// that are there.
func addFiles(document []byte, file string) ([]byte, error) {
	var into, from map[string]any
	if err := json.Unmarshal(document, &into); err != nil {
		return nil, err
	}
	content, err := os.ReadFile(file)
	if err != nil {
		return nil, err
	}
	if err := yaml.Unmarshal(content, &from); err != nil {
		return nil, fmt.Errorf("%s: %w", file, err)
	}
	into["info"] = from["info"]
	into["tags"] = append(into["tags"].([]any), from["tags"].([]any)...)
	components := into["components"].(map[string]any)
	for name, part := range from["components"].(map[string]any) {
		components[name] = part
	}
	paths := into["paths"].(map[string]any)
	for path, item := range from["paths"].(map[string]any) {
		known, ok := paths[path].(map[string]any)
		if !ok {
			paths[path] = item
			continue
		}
		for method, operation := range item.(map[string]any) {
			known[method] = operation // the gateway's own answer goes before the RPC's
		}
	}
	return json.Marshal(into)
}
