# One image with the daemon and the page: docker build -t laglab . (how to run it: docs/deploy.md)
# The base is Debian's image of 3 August 2026, by the digest of its index in github.com/docker-library/repo-info; what Debian has mended since comes by
# `upgrade`. Where no registry can be reached: deploy/base-image makes one of Debian's packages, and --build-arg BASE=... names it.
ARG BASE=debian:bookworm-slim@sha256:abd67ffcfa541b485a3dff59865ab629aa048a6c613e639d36e7456b0b229241

FROM ${BASE} AS build
RUN apt-get update \
    && apt-get install -y --no-install-recommends gcc libc6-dev cmake ninja-build pkg-config nodejs npm python3 ca-certificates \
        libmicrohttpd-dev libwebsockets-dev libwebsockets-evlib-ev libev-dev libcjson-dev libsqlite3-dev libssl-dev zlib1g-dev \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /laglab
# Node has authorities of its own; these are the base's, with those that an own network needs.
ENV NODE_EXTRA_CA_CERTS=/etc/ssl/certs/ca-certificates.crt
# Alone, so that a change of a source does not fetch the page's libraries again, what bundles it and what makes the types of the client.
COPY package.json package-lock.json .npmrc ./
RUN npm ci --ignore-scripts
COPY . .
RUN ./dev release \
    && mkdir /out \
    && strip -o /out/laglab build/profiled/laglab \
    && cp -r build/profiled/www build/profiled/scenarios build/profiled/api LICENSE /out/

FROM ${BASE} AS runtime
RUN apt-get update \
    && apt-get upgrade -y \
    && apt-get install -y --no-install-recommends libmicrohttpd12 libwebsockets17 libwebsockets-evlib-ev libcjson1 libsqlite3-0 libssl3 zlib1g \
    && rm -rf /var/lib/apt/lists/* /var/cache/apt/* /var/log/* \
    && install -d -o 10001 -g 10001 /data

# What is in the image: Debian's packages, and the page's libraries by the checksums that npm held them against.
FROM runtime AS packages
RUN dpkg-query -W -f '${binary:Package}\t${Version}\t${Architecture}\t${source:Package}\t${source:Version}\n' > /packages.tsv
FROM build AS sbom
COPY --from=packages /packages.tsv /packages.tsv
RUN node deploy/sbom.mjs /packages.tsv > /sbom.spdx.json

FROM runtime
# The binary finds www, scenarios and api beside itself.
COPY --from=build /out /opt/laglab
COPY --from=sbom /sbom.spdx.json /opt/laglab/sbom.spdx.json
USER 10001:10001
WORKDIR /data
VOLUME /data
EXPOSE 8080
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=3s --start-period=5s CMD ["/opt/laglab/laglab", "healthcheck"]
ENTRYPOINT ["/opt/laglab/laglab"]
CMD ["serve", "--listen", "0.0.0.0:8080", "--data", "/data"]
