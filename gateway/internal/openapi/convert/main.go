// SPDX-License-Identifier: Apache-2.0

// Command convert turns the OpenAPI 2 document of protoc-gen-openapiv2, which alone reads proto/gateway.yaml, into the
// OpenAPI 3 document that the gateway serves. usage: convert IN OUT
package main

import (
	"context"
	"encoding/json"
	"fmt"
	"os"

	"github.com/getkin/kin-openapi/openapi2"
	"github.com/getkin/kin-openapi/openapi2conv"
)

func main() {
	if err := convert(os.Args[1], os.Args[2]); err != nil {
		fmt.Fprintln(os.Stderr, "convert:", err)
		os.Exit(1)
	}
}

func convert(in, out string) error {
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
	if err := three.Validate(context.Background()); err != nil {
		return err
	}
	encoded, err := json.MarshalIndent(three, "", " ")
	if err != nil {
		return err
	}
	return os.WriteFile(out, encoded, 0o644)
}
