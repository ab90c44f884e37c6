// SPDX-License-Identifier: Apache-2.0

package files

import (
	"context"
	"net/http"
	"path"
	"strconv"
	"strings"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"

	pb "enfilade/gateway/gen/enfilade/v1"
	"enfilade/gateway/internal/rest"
)

func (h *handlers) priorMapRoutes() []route {
	return []route{
		{"POST", "/v1/{parent=sites/*}/priorMaps:import", h.importPriorMap},
		{"GET", "/v1/{name=sites/*/priorMaps/*}/files", h.listPriorMapFiles},
		{"GET HEAD", "/v1/{name=sites/*/priorMaps/*}/files/{file}", h.sendPriorMapFile},
	}
}

// What a prior map is exported as. Files of other names are the sheet: it keeps the name that it was imported by.
var productOfFile = map[string]string{
	"plan.geojson": "plan", "walls.geojson": "corrected", "walls.svg": "corrected", "walls.building.yaml": "corrected",
	"planning.png": "planning", "planning.yaml": "planning", "planning-mask.png": "planning", "fit.png": "picture",
}

// Kinds of files that only prior maps have; those of maps are in mediaTypes.
var priorMediaTypes = map[string]string{
	".dxf": "image/vnd.dxf", ".geojson": "application/geo+json", ".jpeg": "image/jpeg", ".jpg": "image/jpeg",
	".pdf": "application/pdf", ".svg": "image/svg+xml",
}

func priorMediaType(file string) string {
	extension := strings.ToLower(path.Ext(file))
	for _, types := range []map[string]string{mediaTypes, priorMediaTypes} {
		if found, ok := types[extension]; ok {
			return found
		}
	}
	return "application/octet-stream"
}

// Products by the name that a client gives; none: all that there are.
func productsOf(name string) ([]pb.PriorMapProduct, error) {
	if name == "" {
		return nil, nil
	}
	product, ok := pb.PriorMapProduct_value["PRIOR_MAP_PRODUCT_"+strings.ToUpper(name)]
	if !ok || product == 0 {
		return nil, status.Errorf(codes.InvalidArgument,
			"product: %q is not one of sheet, plan, corrected, planning and picture", name)
	}
	return []pb.PriorMapProduct{pb.PriorMapProduct(product)}, nil
}

func (h *handlers) openPriorMap(ctx context.Context, name, productName string) (*export[*pb.ExportPriorMapManifest], error) {
	products, err := productsOf(productName)
	if err != nil {
		return nil, err
	}
	return openExport(h.priors.ExportPriorMap(ctx, &pb.ExportPriorMapRequest{Name: name, Products: products}))
}

// The files of a prior map, with the paths at which they are found. They change when it is aligned anew.
func (h *handlers) listPriorMapFiles(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	ctx, cancel := context.WithCancel(rest.ContextOf(r))
	defer cancel()
	product := r.URL.Query().Get("product")
	export, err := h.openPriorMap(ctx, path["name"], product)
	if err != nil {
		return err
	}
	return writeLinks(w, "priorMap", path["name"], export.manifest.GetFiles(), "product", product)
}

func (h *handlers) sendPriorMapFile(w http.ResponseWriter, r *http.Request, variables map[string]string) error {
	ctx, cancel := context.WithCancel(rest.ContextOf(r))
	defer cancel()
	product := r.URL.Query().Get("product")
	if product == "" {
		product = productOfFile[variables["file"]]
	}
	if product == "" {
		product = "sheet"
	}
	export, err := h.openPriorMap(ctx, variables["name"], product)
	if err != nil {
		return err
	}
	if export.send(w, r, variables["file"], priorMediaType) {
		return nil
	}
	return status.Errorf(codes.NotFound, "%s has no file %s", variables["name"], variables["file"])
}

func numberOf(fields map[string]string, name string) (int32, error) {
	text := strings.TrimSpace(fields[name])
	if text == "" {
		return 0, nil
	}
	number, err := strconv.ParseInt(text, 10, 32)
	if err != nil {
		return 0, status.Errorf(codes.InvalidArgument, "%s: %q is not a whole number", name, text)
	}
	return int32(number), nil
}

// X1,Y1,X2,Y2=METRES; nil: none is given.
func measureOf(text string) (*pb.PlanMeasure, error) {
	if text = strings.TrimSpace(text); text == "" {
		return nil, nil
	}
	points, length, _ := strings.Cut(text, "=")
	parts := append(strings.Split(points, ","), length)
	numbers := make([]float64, len(parts))
	for i, part := range parts {
		var err error
		if numbers[i], err = strconv.ParseFloat(strings.TrimSpace(part), 64); err != nil {
			return nil, status.Errorf(codes.InvalidArgument, "measure: %q is not X1,Y1,X2,Y2=METRES", text)
		}
	}
	if len(numbers) != 5 {
		return nil, status.Errorf(codes.InvalidArgument, "measure: %q is not X1,Y1,X2,Y2=METRES", text)
	}
	return &pb.PlanMeasure{FromX: numbers[0], FromY: numbers[1], ToX: numbers[2], ToY: numbers[3], LengthM: numbers[4]}, nil
}

func priorMapManifest(parent string, upload *form) (*pb.ImportPriorMapManifest, error) {
	if len(upload.files) != 1 {
		return nil, status.Errorf(codes.InvalidArgument, "one file is needed, and %d came", len(upload.files))
	}
	level, err := numberOf(upload.fields, "level")
	if err != nil {
		return nil, err
	}
	page, err := numberOf(upload.fields, "page")
	if err != nil {
		return nil, err
	}
	file := upload.files[0]
	manifest := &pb.ImportPriorMapManifest{
		Parent: parent, PriorMapId: upload.fields["prior_map_id"], DisplayName: upload.fields["display_name"],
		Level: level, Page: page, PlanLevel: upload.fields["plan_level"],
		File: &pb.FileEntry{Name: file.name, SizeBytes: file.size, Sha256: file.digest},
	}
	if manifest.Measure, err = measureOf(upload.fields["measure"]); err != nil {
		return nil, err
	}
	for _, layer := range strings.Split(upload.fields["layers"], ",") {
		if layer = strings.TrimSpace(layer); layer != "" {
			manifest.Layers = append(manifest.Layers, layer)
		}
	}
	return manifest, nil
}

// One file, with what is told of it in the fields display_name, level, prior_map_id, page, plan_level, layers (with
// commas between) and measure (X1,Y1,X2,Y2=METRES), becomes a prior map.
func (h *handlers) importPriorMap(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	upload, err := readForm(w, r, h.limits)
	if err != nil {
		return err
	}
	defer upload.close()
	manifest, err := priorMapManifest(path["parent"], upload)
	if err != nil {
		return err
	}
	stream, err := h.priors.ImportPriorMap(rest.ContextOf(r))
	if err != nil {
		return err
	}
	err = stream.Send(&pb.ImportPriorMapRequest{Content: &pb.ImportPriorMapRequest_Manifest{Manifest: manifest}})
	if err == nil {
		_ = upload.files[0].sendChunks(func(offset int64, data []byte) error {
			return stream.Send(&pb.ImportPriorMapRequest{Content: &pb.ImportPriorMapRequest_Chunk{
				Chunk: &pb.FileChunk{Offset: offset, Data: data}}})
		})
	}
	response, err := stream.CloseAndRecv() // has the reason if sending failed
	return answer(w, response, err)
}
