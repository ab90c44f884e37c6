// SPDX-License-Identifier: Apache-2.0
#include "client/sdk/api/evidence.h"

#include <cstdint>
#include <utility>

#include "client/sdk/api/chunks.h"
#include "core/base/sha256.h"
#include "core/base/status_macros.h"
#include "enfilade/v1/link_point_service.grpc.pb.h"

namespace enfilade::client {

absl::StatusOr<v1::Evidence> AttachEvidence(const Connection& connection, const std::string& link_point,
                                            v1::Evidence evidence, std::string_view bytes) {
  v1::BlobRef content;
  content.set_sha256(Sha256(bytes));
  content.set_size_bytes(static_cast<std::int64_t>(bytes.size()));
  *(evidence.has_cloud() ? evidence.mutable_cloud()->mutable_content() : evidence.mutable_image()->mutable_content()) =
      content;
  v1::LinkPointService::Stub stub(connection.channel());
  grpc::ClientContext context;
  connection.SetActor(context);
  connection.SetDeadline(context);
  v1::AttachEvidenceResponse response;
  const auto writer = stub.AttachEvidence(&context, &response);
  v1::AttachEvidenceRequest request;
  request.mutable_manifest()->set_parent(link_point);
  *request.mutable_manifest()->mutable_evidence() = std::move(evidence);
  if (writer->Write(request)) {
    SendBlobChunks(content, bytes, [&](v1::BlobChunk chunk) {
      *request.mutable_chunk() = std::move(chunk);
      return writer->Write(request);
    });
  }
  writer->WritesDone();  // if the server has ended the call, Finish has the reason
  ENFILADE_RETURN_IF_ERROR(FromGrpcStatus(writer->Finish(), connection.address()));
  return response.evidence();
}

}  // namespace enfilade::client
