// Lets a page of a plain static host bake: it adds the two headers that threads need. Copy it beside the page, and load
// it first: <script src="isolate.js"></script>. In the page it registers itself and loads the page again, once. A page
// that takes files waits for the promise window.halflightIsolating first, where there is one.
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
    const key = 'halflight-isolated'; // of a page that was loaded again, until it is isolated
    const script = document.currentScript.src;
    let again;
    try {
        again = localStorage.getItem(key) !== null;
        if (crossOriginIsolated) localStorage.removeItem(key);
    } catch {
        again = true; // without storage nothing would tell the second time from the first
    }
    const isFramed = window !== window.top; // only the page around it could isolate it
    if (crossOriginIsolated || again || isFramed || !navigator.serviceWorker) return;
    const ready = navigator.serviceWorker.register(script).then(() => navigator.serviceWorker.ready);
    const late = new Promise((resolve) => setTimeout(resolve, 5000));
    window.halflightIsolating = Promise.race([ready, late]).then((registration) => {
        if (!registration) return;
        localStorage.setItem(key, 'reloaded');
        location.reload();
        return new Promise(() => {}); // nothing goes on meanwhile
    }, () => {});
})();
