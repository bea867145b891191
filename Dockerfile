# One image with the daemon and the page: docker build -t laglab .
#   docker run --read-only -p 8080:8080 -v laglab:/data laglab
FROM debian:bookworm-slim AS build
RUN apt-get update \
    && apt-get install -y --no-install-recommends gcc libc6-dev cmake ninja-build pkg-config nodejs npm ca-certificates \
        libmicrohttpd-dev libcjson-dev libsqlite3-dev libpq-dev libssl-dev zlib1g-dev \
    && rm -rf /var/lib/apt/lists/*
WORKDIR /laglab
# Alone, so that a change of a source does not fetch the page's libraries again.
COPY package.json package-lock.json .npmrc ./
RUN npm ci --ignore-scripts --omit=dev
COPY . .
RUN cmake --preset release -DLAGLAB_TESTS=OFF \
    && cmake --build --preset release \
    && mkdir /out \
    && strip -o /out/laglab build/laglab \
    && cp -r build/www build/scenarios build/api LICENSE /out/

FROM debian:bookworm-slim
RUN apt-get update \
    && apt-get install -y --no-install-recommends libmicrohttpd12 libcjson1 libsqlite3-0 libpq5 libssl3 zlib1g \
    && rm -rf /var/lib/apt/lists/* \
    && install -d -o 10001 -g 10001 /data
# The binary finds www, scenarios and api beside itself.
COPY --from=build /out /opt/laglab
USER 10001:10001
WORKDIR /data
VOLUME /data
EXPOSE 8080
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=3s --start-period=5s CMD ["/opt/laglab/laglab", "healthcheck"]
ENTRYPOINT ["/opt/laglab/laglab"]
CMD ["serve", "--listen", "0.0.0.0:8080", "--data", "/data"]
