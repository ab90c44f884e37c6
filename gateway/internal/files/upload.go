// SPDX-License-Identifier: Apache-2.0

package files

import (
	"bytes"
	"crypto/sha256"
	"errors"
	"fmt"
	"hash"
	"io"
	"mime/multipart"
	"net/http"
	"os"
	"strings"

	"google.golang.org/grpc/codes"
	"google.golang.org/grpc/status"
	"google.golang.org/protobuf/encoding/protojson"
	"google.golang.org/protobuf/proto"

	pb "enfilade/gateway/gen/enfilade/v1"
	"enfilade/gateway/internal/rest"
)

// UploadLimits bound what one upload may hold.
type UploadLimits struct {
	Bytes int64 // of all its files
	Files int
}

// DefaultUploadLimits are those of the server.
func DefaultUploadLimits() UploadLimits { return UploadLimits{Bytes: 512 << 20, Files: 16} }

const chunkBytes = 1 << 20
const fieldBytes = 64 << 10

// spooled is an uploaded file, on disk, because its digest must be told before its content.
type spooled struct {
	name   string
	file   *os.File
	size   int64
	digest []byte
}

type form struct {
	fields map[string]string
	files  []*spooled
}

func (f *form) close() {
	for _, file := range f.files {
		_ = file.file.Close()
	}
}

// readForm reads multipart/form-data as it comes; its files go to disk, where nothing of them is left afterwards.
func readForm(w http.ResponseWriter, r *http.Request, limits UploadLimits) (*form, error) {
	r.Body = http.MaxBytesReader(w, r.Body, limits.Bytes+fieldBytes)
	reader, err := r.MultipartReader()
	if err != nil {
		return nil, status.Error(codes.InvalidArgument, "the body must be multipart/form-data with the files to upload")
	}
	result := &form{fields: map[string]string{}}
	for {
		part, err := reader.NextPart()
		if err == io.EOF {
			return result, nil
		}
		if err == nil {
			err = result.add(part, limits)
		}
		if err != nil {
			result.close()
			return nil, explain(err, limits)
		}
	}
}

func (f *form) add(part *multipart.Part, limits UploadLimits) error {
	if part.FileName() == "" {
		content, err := io.ReadAll(io.LimitReader(part, fieldBytes))
		f.fields[part.FormName()] = string(content)
		return err
	}
	if len(f.files) == limits.Files {
		return status.Errorf(codes.InvalidArgument, "an upload has at most %d files", limits.Files)
	}
	file, err := spool(part)
	if err != nil {
		return err
	}
	f.files = append(f.files, file)
	return nil
}

func spool(part *multipart.Part) (*spooled, error) {
	file, err := os.CreateTemp("", "enfilade-upload-")
	if err != nil {
		return nil, err
	}
	_ = os.Remove(file.Name()) // gone when it is closed, whatever happens
	digest := sha256.New()
	size, err := io.Copy(io.MultiWriter(file, digest), part)
	if err != nil {
		_ = file.Close()
		return nil, err
	}
	return &spooled{name: part.FileName(), file: file, size: size, digest: sum(digest)}, nil
}

func sum(digest hash.Hash) []byte { return digest.Sum(nil) }

func explain(err error, limits UploadLimits) error {
	var tooLarge *http.MaxBytesError
	if errors.As(err, &tooLarge) {
		return status.Errorf(codes.InvalidArgument, "the upload is larger than %d bytes", limits.Bytes)
	}
	if _, ok := status.FromError(err); ok {
		return err
	}
	var onDisk *os.PathError
	if errors.As(err, &onDisk) {
		return status.Error(codes.ResourceExhausted, "the gateway has no room for the upload")
	}
	return status.Error(codes.InvalidArgument, "the upload ended in the middle")
}

// sendChunks reads a file from its begin and passes its pieces on.
func (s *spooled) sendChunks(send func(offset int64, data []byte) error) error {
	buffer := make([]byte, chunkBytes)
	for offset := int64(0); offset < s.size; {
		count, err := s.file.ReadAt(buffer, offset)
		if count == 0 && err != nil {
			return err
		}
		if err := send(offset, buffer[:count]); err != nil {
			return err
		}
		offset += int64(count)
	}
	return nil
}

// The files of a form, with the dialect ("nav2", "ros1") in a field, become a revision of the map.
func (h *handlers) importMap(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	upload, err := readForm(w, r, h.limits)
	if err != nil {
		return err
	}
	defer upload.close()
	manifest := &pb.ImportMapManifest{Parent: path["name"]}
	if dialect := upload.fields["dialect"]; dialect != "" {
		value, ok := pb.MapDialect_value["MAP_DIALECT_"+strings.ToUpper(dialect)]
		if !ok {
			return status.Errorf(codes.InvalidArgument, "dialect: %q is not one of nav2 and ros1", dialect)
		}
		manifest.Dialect = pb.MapDialect(value)
	}
	for _, file := range upload.files {
		manifest.Files = append(manifest.Files, &pb.FileEntry{Name: file.name, SizeBytes: file.size, Sha256: file.digest})
	}
	stream, err := h.maps.ImportMap(rest.ContextOf(r))
	if err != nil {
		return err
	}
	sent := stream.Send(&pb.ImportMapRequest{Part: &pb.ImportMapRequest_Manifest{Manifest: manifest}})
	for index, file := range upload.files {
		if sent != nil {
			break
		}
		sent = file.sendChunks(func(offset int64, data []byte) error {
			return stream.Send(&pb.ImportMapRequest{Part: &pb.ImportMapRequest_Chunk{
				Chunk: &pb.FileChunk{File: int32(index), Offset: offset, Data: data}}})
		})
	}
	response, err := stream.CloseAndRecv() // has the reason if sending failed
	return answer(w, response, err)
}

// One image or cloud in a file, described by an Evidence (JSON) in the field "evidence", whose blob is filled in.
func (h *handlers) attachEvidence(w http.ResponseWriter, r *http.Request, path map[string]string) error {
	upload, err := readForm(w, r, h.limits)
	if err != nil {
		return err
	}
	defer upload.close()
	if len(upload.files) != 1 {
		return status.Errorf(codes.InvalidArgument, "one file is needed, and %d came", len(upload.files))
	}
	file := upload.files[0]
	evidence := &pb.Evidence{}
	if err := protojson.Unmarshal([]byte(upload.fields["evidence"]), evidence); err != nil {
		return status.Errorf(codes.InvalidArgument, "evidence: %v", err)
	}
	blob := &pb.BlobRef{Sha256: file.digest, SizeBytes: file.size}
	switch content := evidence.GetContent().(type) {
	case *pb.Evidence_Image:
		content.Image.Content = blob
	case *pb.Evidence_Cloud:
		content.Cloud.Content = blob
	default:
		return status.Error(codes.InvalidArgument, "evidence: has neither an image nor a cloud")
	}
	stream, err := h.points.AttachEvidence(rest.ContextOf(r))
	if err != nil {
		return err
	}
	err = stream.Send(&pb.AttachEvidenceRequest{Part: &pb.AttachEvidenceRequest_Manifest{
		Manifest: &pb.EvidenceManifest{Parent: path["name"], Evidence: evidence}}})
	if err == nil {
		_ = file.sendChunks(func(offset int64, data []byte) error {
			return stream.Send(&pb.AttachEvidenceRequest{Part: &pb.AttachEvidenceRequest_Chunk{
				Chunk: &pb.BlobChunk{Blob: blob, Offset: offset, Data: bytes.Clone(data)}}})
		})
	}
	response, err := stream.CloseAndRecv()
	return answer(w, response, err)
}

func answer(w http.ResponseWriter, response proto.Message, err error) error {
	if err != nil {
		return err
	}
	encoded, err := protojson.MarshalOptions{EmitDefaultValues: true}.Marshal(response)
	if err != nil {
		return fmt.Errorf("encoding the answer: %w", err)
	}
	w.Header().Set("Content-Type", "application/json")
	_, _ = w.Write(encoded)
	return nil
}
