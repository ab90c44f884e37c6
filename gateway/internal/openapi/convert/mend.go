// SPDX-License-Identifier: Apache-2.0

package main

import (
	"fmt"
	"strings"

	"github.com/getkin/kin-openapi/openapi3"
)

// Fields whose value may be no finite number: these are texts in the JSON of protobuf.
var notFinite = map[string][]string{
	"v1FindLinkPointsResponse": {"radiusM"},
	"v1FoundLinkPoint":         {"distanceM", "bearingRad", "mahalanobisDistance"},
	"v1LaserScan":              {"rangeMaxM", "rangesM"},
}

// The generator's title of a stream's messages.
const streamTitle = "Stream result of "

// Media types that each stream comes in; see the package rest.
var streamTypes = []string{"application/x-ndjson", "text/event-stream"}

// mend says what the generators do not know.
func mend(document *openapi3.T) error {
	for name, fields := range notFinite {
		schema := document.Components.Schemas[name]
		for _, field := range fields {
			if schema == nil || schema.Value.Properties[field] == nil {
				return fmt.Errorf("there is no %s.%s", name, field)
			}
			property := schema.Value.Properties[field]
			if items := property.Value.Items; items != nil {
				property.Value.Items = numberOrText(items.Value)
			} else {
				schema.Value.Properties[field] = numberOrText(property.Value)
			}
		}
	}
	for _, item := range document.Paths.Map() {
		for _, operation := range item.Operations() {
			mendAnswers(operation)
		}
	}
	return nil
}

func numberOrText(number *openapi3.Schema) *openapi3.SchemaRef {
	texts := openapi3.NewStringSchema().WithEnum("NaN", "Infinity", "-Infinity")
	either := openapi3.NewOneOfSchema(&openapi3.Schema{Type: number.Type, Format: number.Format}, texts)
	either.Description = number.Description
	return openapi3.NewSchemaRef("", either)
}

func mendAnswers(operation *openapi3.Operation) {
	if operation.Responses.Default() == nil {
		status := openapi3.NewContentWithJSONSchemaRef(openapi3.NewSchemaRef("#/components/schemas/rpcStatus", nil))
		operation.Responses.Set("default", &openapi3.ResponseRef{
			Value: openapi3.NewResponse().WithDescription("An error.").WithContent(status)})
	}
	ok := operation.Responses.Value("200")
	if ok == nil {
		return
	}
	message := ok.Value.Content.Get("application/json")
	if message == nil || message.Schema.Value == nil || !strings.HasPrefix(message.Schema.Value.Title, streamTitle) {
		return
	}
	ok.Value.Content = openapi3.Content{}
	for _, mediaType := range streamTypes {
		ok.Value.Content[mediaType] = message
	}
}
