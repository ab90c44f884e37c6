#include "server/rpc/link_point/attach_evidence.h"

#include <utility>

#include "core/base/error.h"
#include "core/base/status_macros.h"
#include "server/rpc/ingest/batch.h"
#include "server/rpc/link_point/convert.h"
#include "server/rpc/status.h"

namespace enfilade::server {
namespace {

class AttachEvidenceReactor final : public grpc::ServerReadReactor<v1::AttachEvidenceRequest> {
 public:
  AttachEvidenceReactor(const Services& services, grpc::CallbackServerContext* call,
                        v1::AttachEvidenceResponse* response)
      : services_(services),
        context_(ContextOf(*call, std::chrono::duration<double>(services.options.database.default_deadline_s))),
        response_(response) {
    StartRead(&request_);
  }

  void OnReadDone(bool ok) override {
    if (!ok) return EndOfChunks();
    const absl::Status status = Take();
    if (status.ok()) return StartRead(&request_);
    Answer(status);
  }

  void OnDone() override {
    services_.metrics.CountCall("AttachEvidence", status_.code(), std::chrono::steady_clock::now() - begin_);
    delete this;
  }

 private:
  absl::Status Take() {
    if (request_.has_manifest() && !begun_) {
      begun_ = true;
      ENFILADE_ASSIGN_OR_RETURN(name_, ParseLinkPointName("manifest.parent", request_.manifest().parent()));
      ENFILADE_ASSIGN_OR_RETURN(evidence_, FromProto(name_, request_.manifest().evidence()));
      return absl::OkStatus();
    }
    if (!request_.has_chunk() || !begun_ || complete_) {
      return InvalidArgument("expected the manifest as the first message, and the chunks of one blob after it");
    }
    if (request_.chunk().blob().sha256() != evidence_.content.sha256) {
      return InvalidArgument("a chunk is of another blob than the manifest names");
    }
    has_chunks_ = true;
    ENFILADE_ASSIGN_OR_RETURN(complete_, blob_.Add(request_.chunk()));
    return absl::OkStatus();
  }

  void EndOfChunks() {
    const bool queued = services_.executor.Post([this] { Answer(Attach()); });
    if (!queued) Answer(absl::ResourceExhaustedError("too many calls are waiting: try again later"));
  }

  absl::Status Attach() {
    if (!begun_) return InvalidArgument("the first message must be the manifest");
    if (has_chunks_ && !complete_) return InvalidArgument("the chunks end before the blob does");
    if (complete_) {
      const IngestBlob blob = blob_.Take();
      ENFILADE_RETURN_IF_ERROR(services_.blobs.Put(context_, name_.site, {{evidence_.content.sha256, blob.data}}));
    }
    ENFILADE_RETURN_IF_ERROR(services_.link_points.PutEvidence(context_, name_.site, evidence_));
    *response_->mutable_evidence() = ToProto(name_.site, evidence_);
    return absl::OkStatus();
  }

  void Answer(const absl::Status& status) {
    status_ = status;
    Finish(ToGrpcStatus(status));
  }

  const Services& services_;
  const CallContext context_;
  const std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  v1::AttachEvidenceResponse* const response_;
  v1::AttachEvidenceRequest request_;
  bool begun_ = false;
  bool has_chunks_ = false;
  bool complete_ = false;
  LinkPointName name_;
  Evidence evidence_;
  BlobAssembly blob_;
  absl::Status status_;
};

}  // namespace

grpc::ServerReadReactor<v1::AttachEvidenceRequest>* AttachEvidence(const Services& services,
                                                                   grpc::CallbackServerContext* call,
                                                                   v1::AttachEvidenceResponse* response) {
  return new AttachEvidenceReactor(services, call, response);
}

}  // namespace enfilade::server
