// SPDX-License-Identifier: Apache-2.0

package files

import (
	"encoding/hex"
	"encoding/json"
	"net/http"
	"net/url"

	pb "enfilade/gateway/gen/enfilade/v1"
)

type fileList interface {
	comparable
	GetFiles() []*pb.FileEntry
}

type exportPart[M fileList] interface {
	chunked
	GetManifest() M
}

// An export of the server: its manifest, with which it begins, and then the chunks of its files.
type export[M fileList] struct {
	manifest M
	receive  func() (*pb.FileChunk, error)
}

// Takes what the call that begins the export returns.
func openExport[M fileList, R exportPart[M]](stream interface{ Recv() (R, error) }, err error) (*export[M], error) {
	if err != nil {
		return nil, err
	}
	first, err := stream.Recv()
	if err != nil {
		return nil, err
	}
	var none M
	if first.GetManifest() == none {
		return nil, errNoManifest
	}
	return &export[M]{first.GetManifest(), func() (*pb.FileChunk, error) { return chunk(stream.Recv()) }}, nil
}

// Sends one of its files; false, and nothing is sent, if it has none of that name.
func (e *export[M]) send(w http.ResponseWriter, r *http.Request, name string, mediaType func(string) string) bool {
	for index, entry := range e.manifest.GetFiles() {
		if entry.GetName() != name {
			continue
		}
		Send(w, r, &File{
			Name: name, Size: entry.GetSizeBytes(), SHA256: entry.GetSha256(), MediaType: mediaType(name),
			Next: chunksOf(int32(index), e.receive),
		})
		return true
	}
	return false
}

type fileLink struct {
	Name      string `json:"name"`
	SizeBytes int64  `json:"sizeBytes,string"`
	SHA256    string `json:"sha256"`
	Path      string `json:"path"`
}

// Answers with a resource's files and the paths at which they are found. `kind`: the member with the resource's name;
// `option`: of the address, if it was given, which then is in the paths, too.
func writeLinks(w http.ResponseWriter, kind, resource string, entries []*pb.FileEntry, option, value string) error {
	options := url.Values{}
	if value != "" {
		options.Set(option, value)
	}
	return writeLinksAt(w, kind, resource, resource, entries, options)
}

// The same with files that are found below `folder`.
func writeLinksAt(w http.ResponseWriter, kind, resource, folder string, entries []*pb.FileEntry, options url.Values) error {
	links := []fileLink{}
	for _, file := range entries {
		link := "/v1/" + folder + "/files/" + url.PathEscape(file.GetName())
		if len(options) > 0 {
			link += "?" + options.Encode()
		}
		links = append(links, fileLink{file.GetName(), file.GetSizeBytes(), hex.EncodeToString(file.GetSha256()), link})
	}
	w.Header().Set("Content-Type", "application/json")
	w.Header().Set("Cache-Control", "private, no-cache")
	return json.NewEncoder(w).Encode(map[string]any{kind: resource, "files": links})
}
