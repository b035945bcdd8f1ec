// Lets a page of a plain static host bake: it adds the two headers that threads need. Copy it beside the page, and load it
// first: <script src="isolate.js"></script>. In the page it registers itself and loads the page again, once.
(() => {
    if (typeof window === 'undefined') {
        self.addEventListener('install', () => self.skipWaiting());
        self.addEventListener('activate', (event) => event.waitUntil(self.clients.claim()));
        self.addEventListener('fetch', (event) => {
            const { request } = event;
            if (request.cache === 'only-if-cached' && request.mode !== 'same-origin') return;
            event.respondWith(
                fetch(request).then((response) => {
                    if (response.status === 0) return response; // of another host, which nobody may read
                    const headers = new Headers(response.headers);
                    headers.set('Cross-Origin-Opener-Policy', 'same-origin');
                    headers.set('Cross-Origin-Embedder-Policy', 'require-corp');
                    headers.set('Cross-Origin-Resource-Policy', 'cross-origin');
                    const { status, statusText } = response;
                    return new Response(response.body, { status, statusText, headers });
                })
            );
        });
        return;
    }
    const key = 'halflight-isolated';
    if (crossOriginIsolated || !navigator.serviceWorker || sessionStorage.getItem(key)) return;
    navigator.serviceWorker.register(document.currentScript.src).then(() => navigator.serviceWorker.ready).then(() => {
        sessionStorage.setItem(key, 'reloaded');
        location.reload();
    });
})();
