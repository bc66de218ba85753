// A virtual OpenNI2 sensor: serves the images of a dump file as a live device, for tests.
//
// ADIBAS_VIRTUAL_SENSOR names the dump: blocks of a header of six int32 (OniSensorType,
// OniPixelFormat, width, height, frames/s, number of images) and the images, one block a video
// mode. All streams share one clock, so that image k of each belongs to the same moment.
//
// Files beside the dump play the world: DUMP.unplug (the sensor goes; without it,
// comes back), DUMP.silence (it stays but sends nothing), DUMP.gone (it was never there), DUMP.mirrored (mirroring cannot be switched
// off), DUMP.plain (neither registration nor frame synchronisation), DUMP.second (there are two
// of them, with images in another order), DUMP.twins (both have one serial number).

#include <cstddef>
#define XN_NEW(type, ...) (new type(__VA_ARGS__))
#define XN_DELETE(pointer) (delete (pointer))
#include "Driver/OniDriverAPI.h"

#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <thread>
#include <unistd.h>
#include <vector>

using namespace oni::driver;

namespace {

const int TICK_RATE_HZ = 30;
const int REGISTRATION_SHIFT = 8;  // columns by which a registered depth image is moved
const float FOV_RAD[2] = {1.0145f, 0.7898f};

struct Block {
    OniSensorType sensor;
    OniVideoMode mode;
    std::vector<std::vector<char>> images;
};

std::string dump_path() {
    const char* path = std::getenv("ADIBAS_VIRTUAL_SENSOR");
    return path ? path : "";
}

bool is_told(const char* what) { return access((dump_path() + what).c_str(), F_OK) == 0; }

int bytes_per_pixel(OniPixelFormat format) { return format == ONI_PIXEL_FORMAT_RGB888 ? 3 : 2; }

bool same_mode(const OniVideoMode& a, const OniVideoMode& b) {
    return a.pixelFormat == b.pixelFormat && a.resolutionX == b.resolutionX &&
           a.resolutionY == b.resolutionY && a.fps == b.fps;
}

std::vector<Block> read_dump() {
    std::vector<Block> blocks;
    std::ifstream file(dump_path(), std::ios::binary);
    int32_t head[6];
    while (file.read(reinterpret_cast<char*>(head), sizeof head)) {
        Block block;
        block.sensor = static_cast<OniSensorType>(head[0]);
        block.mode = {static_cast<OniPixelFormat>(head[1]), head[2], head[3], head[4]};
        size_t size = size_t(head[2]) * head[3] * bytes_per_pixel(block.mode.pixelFormat);
        block.images.assign(head[5], std::vector<char>(size));
        for (auto& image : block.images) file.read(image.data(), size);
        blocks.push_back(block);
    }
    return blocks;
}

template <typename T>
OniStatus give(const T& value, void* data, int* size) {
    if (*size != int(sizeof(T))) return ONI_STATUS_BAD_PARAMETER;
    std::memcpy(data, &value, sizeof(T));
    return ONI_STATUS_OK;
}

class Stream : public StreamBase {
public:
    Stream(OniSensorType sensor, const std::vector<Block>& blocks) : sensor_(sensor), blocks_(blocks) {
        for (const Block& block : blocks_)
            if (block.sensor == sensor) { mode_ = block.mode; break; }
    }

    OniStatus start() override { running = true; return ONI_STATUS_OK; }
    void stop() override { running = false; }

    OniBool isPropertySupported(int id) override {
        return id == ONI_STREAM_PROPERTY_VIDEO_MODE || id == ONI_STREAM_PROPERTY_MIRRORING ||
               id == ONI_STREAM_PROPERTY_HORIZONTAL_FOV || id == ONI_STREAM_PROPERTY_VERTICAL_FOV;
    }

    OniStatus getProperty(int id, void* data, int* size) override {
        switch (id) {
        case ONI_STREAM_PROPERTY_VIDEO_MODE: return give(mode_, data, size);
        case ONI_STREAM_PROPERTY_MIRRORING: return give(mirrored_, data, size);
        case ONI_STREAM_PROPERTY_HORIZONTAL_FOV: return give(FOV_RAD[0], data, size);
        case ONI_STREAM_PROPERTY_VERTICAL_FOV: return give(FOV_RAD[1], data, size);
        default: return ONI_STATUS_NOT_IMPLEMENTED;
        }
    }

    OniStatus setProperty(int id, const void* data, int) override {
        if (id == ONI_STREAM_PROPERTY_MIRRORING && !is_told(".mirrored")) {
            mirrored_ = *static_cast<const OniBool*>(data);
            return ONI_STATUS_OK;
        }
        if (id != ONI_STREAM_PROPERTY_VIDEO_MODE) return ONI_STATUS_NOT_SUPPORTED;
        const OniVideoMode& wanted = *static_cast<const OniVideoMode*>(data);
        for (const Block& block : blocks_)
            if (block.sensor == sensor_ && same_mode(block.mode, wanted)) {
                mode_ = wanted;
                return ONI_STATUS_OK;
            }
        return ONI_STATUS_NOT_SUPPORTED;
    }

    // Sends the image of this tick, if the stream's rate has one.
    void tick(int number, uint64_t time_us, bool is_registered) {
        const int divisor = TICK_RATE_HZ / mode_.fps;
        if (!running || number % divisor != 0) return;
        for (const Block& block : blocks_)
            if (block.sensor == sensor_ && same_mode(block.mode, mode_))
                send(block, number / divisor, time_us, is_registered);
    }

    OniSensorType sensor() const { return sensor_; }
    std::atomic<bool> running{false};

private:
    void send(const Block& block, int index, uint64_t time_us, bool is_registered) {
        OniFrame* frame = getServices().acquireFrame();
        if (frame == NULL) return;
        const std::vector<char>& image = block.images[index % block.images.size()];
        const int pixel = bytes_per_pixel(mode_.pixelFormat), width = mode_.resolutionX;
        const int shift = is_registered && sensor_ == ONI_SENSOR_DEPTH ? REGISTRATION_SHIFT : 0;
        char* out = static_cast<char*>(frame->data);
        for (int row = 0; row < mode_.resolutionY; ++row)
            for (int column = 0; column < width; ++column) {
                const int seen = mirrored_ ? width - 1 - column : column;
                const size_t from = size_t(row) * width + (seen + shift) % width;
                std::memcpy(out, &image[from * pixel], pixel);
                out += pixel;
            }
        frame->dataSize = int(image.size());
        frame->sensorType = sensor_;
        frame->timestamp = time_us;
        frame->frameIndex = index + 1;
        frame->width = width;
        frame->height = mode_.resolutionY;
        frame->videoMode = mode_;
        frame->croppingEnabled = FALSE;
        frame->cropOriginX = frame->cropOriginY = 0;
        frame->stride = width * pixel;
        raiseNewFrame(frame);
        getServices().releaseFrame(frame);
    }

    const OniSensorType sensor_;
    const std::vector<Block>& blocks_;
    OniVideoMode mode_;
    OniBool mirrored_ = TRUE;  // as PrimeSense sensors wake up
};

class Device : public DeviceBase {
public:
    Device(const std::vector<Block>& blocks, int number) : blocks_(blocks), number_(number) {
        for (const Block& block : blocks_) modes_[block.sensor].push_back(block.mode);
        for (auto& entry : modes_)
            sensors_.push_back({entry.first, int(entry.second.size()), entry.second.data()});
    }

    OniStatus getSensorInfoList(OniSensorInfo** sensors, int* count) override {
        *sensors = sensors_.data();
        *count = int(sensors_.size());
        return ONI_STATUS_OK;
    }

    StreamBase* createStream(OniSensorType sensor) override {
        std::lock_guard<std::mutex> lock(mutex_);
        // A PrimeSense sensor has one path for colour and infrared.
        for (Stream* other : streams_)
            if (int(other->sensor()) + int(sensor) == ONI_SENSOR_IR + ONI_SENSOR_COLOR &&
                other->sensor() != sensor)
                return NULL;
        Stream* stream = new Stream(sensor, blocks_);
        streams_.insert(stream);
        return stream;
    }

    void destroyStream(StreamBase* stream) override {
        std::lock_guard<std::mutex> lock(mutex_);
        streams_.erase(static_cast<Stream*>(stream));
        delete stream;
    }

    OniBool isPropertySupported(int id) override {
        return id == ONI_DEVICE_PROPERTY_SERIAL_NUMBER ||
               (id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION && !is_told(".plain"));
    }

    OniStatus getProperty(int id, void* data, int* size) override {
        if (id == ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return give(registration_, data, size);
        if (id != ONI_DEVICE_PROPERTY_SERIAL_NUMBER) return ONI_STATUS_NOT_IMPLEMENTED;
        const char* serial = number_ == 0 || is_told(".twins") ? "VIRTUAL-0001" : "VIRTUAL-0002";
        std::strncpy(static_cast<char*>(data), serial, size_t(*size));
        return ONI_STATUS_OK;
    }

    OniStatus setProperty(int id, const void* data, int) override {
        if (id != ONI_DEVICE_PROPERTY_IMAGE_REGISTRATION) return ONI_STATUS_NOT_SUPPORTED;
        registration_ = *static_cast<const OniImageRegistrationMode*>(data);
        return ONI_STATUS_OK;
    }

    OniBool isImageRegistrationModeSupported(OniImageRegistrationMode mode) override {
        return mode == ONI_IMAGE_REGISTRATION_OFF || !is_told(".plain");
    }

    void tick(int number, uint64_t time_us) {
        std::lock_guard<std::mutex> lock(mutex_);
        for (Stream* stream : streams_)
            stream->tick(number + 2 * number_, time_us, registration_ == ONI_IMAGE_REGISTRATION_DEPTH_TO_COLOR);
    }

private:
    const std::vector<Block>& blocks_;
    const int number_;
    std::map<OniSensorType, std::vector<OniVideoMode>> modes_;
    std::vector<OniSensorInfo> sensors_;
    std::set<Stream*> streams_;
    std::mutex mutex_;
    OniImageRegistrationMode registration_ = ONI_IMAGE_REGISTRATION_OFF;
};

}  // namespace

class VirtualDriver : public DriverBase {
public:
    explicit VirtualDriver(OniDriverServices* services) : DriverBase(services), blocks_(read_dump()) {
        std::memset(infos_, 0, sizeof infos_);
        for (int number = 0; number < 2; ++number) {
            std::strcpy(infos_[number].uri, number == 0 ? "virtual/0" : "virtual/1");
            std::strcpy(infos_[number].vendor, "PrimeSense");
            std::strcpy(infos_[number].name, "Virtual sensor");
        }
    }

    OniStatus initialize(DeviceConnectedCallback connected, DeviceDisconnectedCallback disconnected,
                         DeviceStateChangedCallback changed, void* cookie) override {
        DriverBase::initialize(connected, disconnected, changed, cookie);
        if (!is_told(".gone")) deviceConnected(&infos_[0]);
        if (is_told(".second")) deviceConnected(&infos_[1]);
        clock_ = std::thread([this] { run(); });
        return ONI_STATUS_OK;
    }

    DeviceBase* deviceOpen(const char* uri, const char*) override {
        std::lock_guard<std::mutex> lock(mutex_);
        Device* device = new Device(blocks_, std::strcmp(uri, infos_[0].uri) == 0 ? 0 : 1);
        devices_.insert(device);
        return device;
    }

    void deviceClose(DeviceBase* device) override {
        std::lock_guard<std::mutex> lock(mutex_);
        devices_.erase(static_cast<Device*>(device));
        delete device;
    }

    void shutdown() override {
        is_over_ = true;
        if (clock_.joinable()) clock_.join();
    }

private:
    void run() {
        const auto begin = std::chrono::steady_clock::now();
        const std::chrono::microseconds period(1000000 / TICK_RATE_HZ);
        bool is_plugged = true;
        for (int number = 0; !is_over_; ++number) {
            std::this_thread::sleep_until(begin + number * period);
            if (is_plugged && is_told(".unplug")) {
                is_plugged = false;
                deviceDisconnected(&infos_[0]);
            } else if (!is_plugged && !is_told(".unplug")) {
                is_plugged = true;
                deviceConnected(&infos_[0]);
            }
            std::lock_guard<std::mutex> lock(mutex_);
            if (!is_plugged || is_told(".silence")) continue;
            for (Device* device : devices_)
                device->tick(number, uint64_t(number) * period.count());
        }
    }

    const std::vector<Block> blocks_;
    OniDeviceInfo infos_[2];
    std::set<Device*> devices_;
    std::mutex mutex_;
    std::thread clock_;
    std::atomic<bool> is_over_{false};
};

ONI_EXPORT_DRIVER(VirtualDriver)
