// SPDX-License-Identifier: Apache-2.0
#pragma once

// The lines of api.cc, in classes that derive from ApiOf.
//
// One line for each RPC, by its shape. The compiler checks its name and messages against the generated class, and its
// handler, the function of the same name in enfilade::server, against the messages.
#define ENFILADE_UNARY(Rpc)                                                                            \
  grpc::ServerUnaryReactor* Rpc(grpc::CallbackServerContext* context, const v1::Rpc##Request* request, \
                                v1::Rpc##Response* response) override {                                \
    return RunUnary(Enter(#Rpc, context), request, response, Bind(server::Rpc));                       \
  }
// It changes the graph of its site. Of these and those that need the graph, a second argument is the lane.
#define ENFILADE_UNARY_CHANGES_GRAPH(Rpc, ...)                                                                   \
  grpc::ServerUnaryReactor* Rpc(grpc::CallbackServerContext* context, const v1::Rpc##Request* request,           \
                                v1::Rpc##Response* response) override {                                          \
    return RunUnary(Enter(#Rpc, context), request, response, BindChange(context, server::Rpc), In(__VA_ARGS__)); \
  }
// It needs the graph of its site.
#define ENFILADE_UNARY_ON_GRAPH(Rpc, ...)                                                              \
  grpc::ServerUnaryReactor* Rpc(grpc::CallbackServerContext* context, const v1::Rpc##Request* request, \
                                v1::Rpc##Response* response) override {                                \
    return RunUnary(Enter(#Rpc, context), request, response, Bind(server::Rpc), OnGraph(__VA_ARGS__)); \
  }
// Both.
#define ENFILADE_UNARY_CHANGES_READ_GRAPH(Rpc, ...)                                                                   \
  grpc::ServerUnaryReactor* Rpc(grpc::CallbackServerContext* context, const v1::Rpc##Request* request,                \
                                v1::Rpc##Response* response) override {                                               \
    return RunUnary(Enter(#Rpc, context), request, response, BindChange(context, server::Rpc), OnGraph(__VA_ARGS__)); \
  }
// Its answer takes long to make.
#define ENFILADE_BULK_UNARY(Rpc)                                                                       \
  grpc::ServerUnaryReactor* Rpc(grpc::CallbackServerContext* context, const v1::Rpc##Request* request, \
                                v1::Rpc##Response* response) override {                                \
    return RunUnary(Enter(#Rpc, context), request, response, Bind(server::Rpc), In(CallLane::kBulk));  \
  }
// It computes for seconds.
#define ENFILADE_SLOW_UNARY(Rpc)                                                                       \
  grpc::ServerUnaryReactor* Rpc(grpc::CallbackServerContext* context, const v1::Rpc##Request* request, \
                                v1::Rpc##Response* response) override {                                \
    return RunUnary(Enter(#Rpc, context), request, response, Bind(server::Rpc), In(CallLane::kSlow));  \
  }
// It needs the graph of its site, and its Try##Rpc() may answer immediately, without the executor.
#define ENFILADE_UNARY_ON_GRAPH_OR_NOW(Rpc)                                                                            \
  grpc::ServerUnaryReactor* Rpc(grpc::CallbackServerContext* context, const v1::Rpc##Request* request,                 \
                                v1::Rpc##Response* response) override {                                                \
    return RunUnary(Enter(#Rpc, context), request, response, Bind(server::Rpc), BindNow(server::Try##Rpc), OnGraph()); \
  }
#define ENFILADE_SERVER_STREAM(Rpc)                                                                    \
  grpc::ServerWriteReactor<v1::Rpc##Response>* Rpc(grpc::CallbackServerContext* context,               \
                                                   const v1::Rpc##Request* request) override {         \
    return RunServerStream<v1::Rpc##Response>(Enter(#Rpc, context), request, BindStream(server::Rpc)); \
  }
// Its answer is computed for seconds before it begins.
#define ENFILADE_SLOW_SERVER_STREAM(Rpc)                                                              \
  grpc::ServerWriteReactor<v1::Rpc##Response>* Rpc(grpc::CallbackServerContext* context,              \
                                                   const v1::Rpc##Request* request) override {        \
    return RunServerStream<v1::Rpc##Response>(Enter(#Rpc, context), request, BindStream(server::Rpc), \
                                              In(CallLane::kSlow));                                   \
  }
#define ENFILADE_SERVER_STREAM_ON_GRAPH(Rpc)                                                          \
  grpc::ServerWriteReactor<v1::Rpc##Response>* Rpc(grpc::CallbackServerContext* context,              \
                                                   const v1::Rpc##Request* request) override {        \
    return RunServerStream<v1::Rpc##Response>(Enter(#Rpc, context), request, BindStream(server::Rpc), \
                                              OnGraph(CallLane::kBulk));                              \
  }
#define ENFILADE_RAW_SERVER_STREAM(Rpc)                                                                  \
  grpc::ServerWriteReactor<grpc::ByteBuffer>* Rpc(grpc::CallbackServerContext* context,                  \
                                                  const grpc::ByteBuffer* request) override {            \
    return RunRawServerStream<v1::Rpc##Request>(Enter(#Rpc, context), request, BindStream(server::Rpc)); \
  }
#define ENFILADE_WATCH(Rpc)                                                                    \
  grpc::ServerWriteReactor<v1::Rpc##Response>* Rpc(grpc::CallbackServerContext* context,       \
                                                   const v1::Rpc##Request* request) override { \
    return RunWatch<v1::Rpc##Response>(Enter(#Rpc, context), request, BindWatch(server::Rpc)); \
  }
#define ENFILADE_CLIENT_STREAM(Rpc)                                                                                 \
  grpc::ServerReadReactor<v1::Rpc##Request>* Rpc(grpc::CallbackServerContext* context, v1::Rpc##Response* response) \
      override {                                                                                                    \
    return server::Rpc(services_, Enter(#Rpc, context), response);                                                  \
  }
#define ENFILADE_BIDI_STREAM(Rpc)                                                                                    \
  grpc::ServerBidiReactor<v1::Rpc##Request, v1::Rpc##Response>* Rpc(grpc::CallbackServerContext* context) override { \
    return server::Rpc(services_, Enter(#Rpc, context));                                                             \
  }
