# ilon for CI: `docker build -t ilon .`, then `docker run --rm -v "$PWD:/work" ilon check scenarios`.
FROM rust:1-slim-bookworm AS build
WORKDIR /ilon
COPY . .
RUN rustup component add llvm-tools && .ci/dist

FROM debian:bookworm-slim
COPY --from=build /ilon/target/dist/ilon /ilon/target/dist/libilon_c.so /usr/local/bin/
COPY --from=build /ilon/LICENSE-MIT /ilon/LICENSE-APACHE /usr/share/doc/ilon/
# Whoever runs it need not be root, and what it writes is theirs: add `--user "$(id -u):$(id -g)"`.
USER 1000:1000
WORKDIR /work
ENTRYPOINT ["ilon"]
