// SPDX-License-Identifier: Apache-2.0
#include "server/rpc/link_point/attach_evidence.h"

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/rpc/call/client_stream.h"
#include "server/rpc/ingest/batch.h"
#include "server/rpc/link_point/convert.h"

namespace enfilade::server {
namespace {

class EvidenceTaker {
 public:
  explicit EvidenceTaker(const Services& services) : services_(services), blob_(services.uploads) {}

  absl::Status Take(const v1::AttachEvidenceRequest& request) {
    if (request.has_manifest() && !begun_) {
      begun_ = true;
      ENFILADE_ASSIGN_OR_RETURN(name_, convert::ParseLinkPointName("manifest.parent", request.manifest().parent()));
      ENFILADE_ASSIGN_OR_RETURN(evidence_, FromProto(name_, request.manifest().evidence()));
      return absl::OkStatus();
    }
    if (!request.has_chunk() || !begun_ || complete_) {
      return InvalidArgument("expected the manifest as the first message, and the chunks of one blob after it");
    }
    if (request.chunk().blob().sha256() != evidence_.content.sha256) {
      return InvalidArgument("a chunk is of another blob than the manifest names");
    }
    has_chunks_ = true;
    ENFILADE_ASSIGN_OR_RETURN(complete_, blob_.Add(request.chunk()));
    return absl::OkStatus();
  }

  absl::Status Answer(const storage::CallContext& context, v1::AttachEvidenceResponse& response) {
    if (!begun_) return InvalidArgument("the first message must be the manifest");
    if (has_chunks_ && !complete_) return InvalidArgument("the chunks end before the blob does");
    if (complete_) {
      IngestBlob blob = blob_.Take();
      ENFILADE_ASSIGN_OR_RETURN(const std::string data, blob.data.Take());
      ENFILADE_RETURN_IF_ERROR(services_.blobs.Put(context, name_.site, {{evidence_.content.sha256, data}}));
    }
    ENFILADE_RETURN_IF_ERROR(services_.graph_editor.PutEvidence(context, name_.site, evidence_));
    *response.mutable_evidence() = ToProto(name_.site, evidence_);
    return absl::OkStatus();
  }

 private:
  const Services& services_;
  bool begun_ = false;
  bool has_chunks_ = false;
  bool complete_ = false;
  convert::LinkPointName name_;
  storage::Evidence evidence_;
  BlobAssembly blob_;
};

}  // namespace

grpc::ServerReadReactor<v1::AttachEvidenceRequest>* AttachEvidence(const Services& services, const CallEntry& entry,
                                                                   v1::AttachEvidenceResponse* response) {
  return RunClientStream<EvidenceTaker, v1::AttachEvidenceRequest>(entry, response,
                                                                   [&services] { return EvidenceTaker(services); });
}

}  // namespace enfilade::server
