// A ROS 2 robot among two people, made of Fast DDS alone: the stack's peer in tests/ros2_fastdds.rs.
//
// It publishes /odom at 50 Hz, the people as /detections (geometry_msgs/PoseArray) at 20 Hz and /goal_pose, and does what
// /cmd_vel says; the people walk past and ignore it. It ends when the goal is reached and the robot stands, or when the time is
// up, and prints one line of JSON: what a judge outside the stack saw. Messages are written down by hand in CDR, field by field.
//
//     g++ -std=c++17 -O1 ros2_fastdds_robot.cpp -o robot -lfastrtps -lfastcdr && ./robot DOMAIN SECONDS

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <fastdds/rtps/common/SerializedPayload.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

using namespace eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using eprosima::fastrtps::rtps::InstanceHandle_t;
using eprosima::fastrtps::rtps::SerializedPayload_t;

namespace {

constexpr double kStepS = 0.01;
constexpr double kRadiusM = 0.35;
constexpr double kGoalM = 6.0;
constexpr double kToleranceM = 0.3;
constexpr double kSilenceS = 0.5;
constexpr std::uint32_t kLargestMessage = 4096;

struct Pose {
    double x = 0.0, y = 0.0, angle = 0.0;
    void write(Cdr& cdr) const {
        cdr << x << y << 0.0 << 0.0 << 0.0 << std::sin(angle / 2) << std::cos(angle / 2);
    }
};

/// std_msgs/Header of this moment.
void write_header(Cdr& cdr, const std::string& frame) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
    cdr << static_cast<std::int32_t>(ns / 1'000'000'000) << static_cast<std::uint32_t>(ns % 1'000'000'000) << frame;
}

struct Odometry {
    static constexpr const char* type = "nav_msgs::msg::dds_::Odometry_";
    Pose pose;
    double speed = 0.0, rate = 0.0;
    void write(Cdr& cdr) const {
        std::array<double, 36> covariance{};
        write_header(cdr, "odom");
        cdr << std::string("base_link");
        pose.write(cdr);
        cdr << covariance << speed << 0.0 << 0.0 << 0.0 << 0.0 << rate << covariance;
    }
    void read(Cdr&) {}
};

struct PoseArray {
    static constexpr const char* type = "geometry_msgs::msg::dds_::PoseArray_";
    std::vector<Pose> poses;
    void write(Cdr& cdr) const {
        write_header(cdr, "odom");
        cdr << static_cast<std::uint32_t>(poses.size());
        for (const Pose& pose : poses) {
            pose.write(cdr);
        }
    }
    void read(Cdr&) {}
};

struct PoseStamped {
    static constexpr const char* type = "geometry_msgs::msg::dds_::PoseStamped_";
    Pose pose;
    void write(Cdr& cdr) const {
        write_header(cdr, "odom");
        pose.write(cdr);
    }
    void read(Cdr&) {}
};

struct Twist {
    static constexpr const char* type = "geometry_msgs::msg::dds_::Twist_";
    std::array<double, 6> values{};
    void write(Cdr& cdr) const { cdr << values; }
    void read(Cdr& cdr) { cdr >> values; }
};

/// Hands a message to Fast DDS as ROS 2 would: CDR of the machine's byte order behind four bytes that say so.
template <typename Message>
class Type : public TopicDataType {
public:
    Type() {
        setName(Message::type);
        m_typeSize = kLargestMessage;
        m_isGetKeyDefined = false;
    }
    bool serialize(void* data, SerializedPayload_t* payload) override {
        FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->max_size);
        Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
        payload->encapsulation = CDR_LE;
        cdr.serialize_encapsulation();
        static_cast<Message*>(data)->write(cdr);
        payload->length = static_cast<std::uint32_t>(cdr.getSerializedDataLength());
        return true;
    }
    bool deserialize(SerializedPayload_t* payload, void* data) override {
        try {
            FastBuffer buffer(reinterpret_cast<char*>(payload->data), payload->length);
            Cdr cdr(buffer, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR);
            cdr.read_encapsulation();
            static_cast<Message*>(data)->read(cdr);
            return true;
        } catch (const std::exception&) {
            return false;
        }
    }
    std::function<std::uint32_t()> getSerializedSizeProvider(void*) override {
        return [] { return kLargestMessage; };
    }
    void* createData() override { return new Message(); }
    void deleteData(void* data) override { delete static_cast<Message*>(data); }
    bool getKey(void*, InstanceHandle_t*, bool) override { return false; }
};

/// One robot's place in the graph.
class Graph {
public:
    explicit Graph(std::uint32_t domain) {
        DomainParticipantQos qos;
        auto loopback = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
        loopback->interfaceWhiteList.push_back("127.0.0.1");
        qos.transport().use_builtin_transports = false;
        qos.transport().user_transports.push_back(loopback);
        qos.name("fastdds_robot");
        participant_ = require(DomainParticipantFactory::get_instance()->create_participant(domain, qos), "participant");
        publisher_ = require(participant_->create_publisher(PUBLISHER_QOS_DEFAULT), "publisher");
        subscriber_ = require(participant_->create_subscriber(SUBSCRIBER_QOS_DEFAULT), "subscriber");
    }
    template <typename Message>
    DataWriter* writer(const std::string& topic) {
        DataWriterQos qos = DATAWRITER_QOS_DEFAULT;
        qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
        return require(publisher_->create_datawriter(open<Message>(topic), qos), "writer");
    }
    template <typename Message>
    DataReader* reader(const std::string& topic) {
        DataReaderQos qos = DATAREADER_QOS_DEFAULT;
        qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
        return require(subscriber_->create_datareader(open<Message>(topic), qos), "reader");
    }

private:
    template <typename Thing>
    static Thing* require(Thing* thing, const char* what) {
        if (thing == nullptr) {
            std::fprintf(stderr, "Fast DDS refuses a %s\n", what);
            std::exit(2);
        }
        return thing;
    }
    template <typename Message>
    Topic* open(const std::string& topic) {
        TypeSupport type(new Type<Message>());
        type.register_type(participant_);
        return require(participant_->create_topic("rt/" + topic, Message::type, TOPIC_QOS_DEFAULT), "topic");
    }
    DomainParticipant* participant_ = nullptr;
    Publisher* publisher_ = nullptr;
    Subscriber* subscriber_ = nullptr;
};

struct Person {
    double x, y, vx, vy;
};

}  // namespace

int main(int count, char** arguments) {
    if (count != 3) {
        std::fprintf(stderr, "usage: %s DOMAIN SECONDS\n", arguments[0]);
        return 2;
    }
    const double patience_s = std::atof(arguments[2]);
    Graph graph(static_cast<std::uint32_t>(std::atoi(arguments[1])));
    DataWriter* odometry = graph.writer<Odometry>("odom");
    DataWriter* people_seen = graph.writer<PoseArray>("detections");
    DataWriter* goal = graph.writer<PoseStamped>("goal_pose");
    DataReader* commands = graph.reader<Twist>("cmd_vel");

    Odometry robot;
    std::vector<Person> people = {{3.0, -3.0, 0.0, 0.6}, {9.0, 0.3, -0.5, 0.0}};
    double clearance_m = std::numeric_limits<double>::infinity();
    double heard_s = -1.0, reached_s = -1.0;
    bool moves = false;
    unsigned received = 0, refused = 0;
    const auto begin = std::chrono::steady_clock::now();
    double elapsed_s = 0.0;
    for (int step = 0; elapsed_s < patience_s; ++step) {
        elapsed_s = step * kStepS;
        Twist twist;
        SampleInfo info;
        while (commands->take_next_sample(&twist, &info) == ReturnCode_t::RETCODE_OK) {
            if (!info.valid_data) {
                continue;
            }
            const auto& v = twist.values;
            const bool planar = v[1] == 0.0 && v[2] == 0.0 && v[3] == 0.0 && v[4] == 0.0;
            if (!planar || !std::isfinite(v[0]) || !std::isfinite(v[5])) {
                ++refused;
                continue;
            }
            robot.speed = v[0];
            robot.rate = v[5];
            heard_s = elapsed_s;
            ++received;
        }
        if (heard_s < 0.0 || elapsed_s - heard_s > kSilenceS) {
            robot.speed = robot.rate = 0.0;
        }
        moves = moves || robot.speed != 0.0;
        robot.pose.x += robot.speed * std::cos(robot.pose.angle) * kStepS;
        robot.pose.y += robot.speed * std::sin(robot.pose.angle) * kStepS;
        robot.pose.angle += robot.rate * kStepS;
        PoseArray seen;
        for (Person& person : people) {
            if (moves) {
                person.x += person.vx * kStepS;
                person.y += person.vy * kStepS;
            }
            const double distance = std::hypot(person.x - robot.pose.x, person.y - robot.pose.y);
            clearance_m = std::min(clearance_m, distance - 2 * kRadiusM);
            seen.poses.push_back({person.x, person.y, std::atan2(person.vy, person.vx)});
        }
        if (step % 2 == 0) {
            odometry->write(&robot);
        }
        if (step % 5 == 0) {
            people_seen->write(&seen);
        }
        if (step % 50 == 0) {
            PoseStamped aim{{kGoalM, 0.0, 0.0}};
            goal->write(&aim);
        }
        const bool there = std::hypot(kGoalM - robot.pose.x, robot.pose.y) <= kToleranceM;
        if (there && reached_s < 0.0) {
            reached_s = elapsed_s;
        }
        if (reached_s >= 0.0 && robot.speed == 0.0 && elapsed_s > reached_s + 0.5) {
            break;
        }
        std::this_thread::sleep_until(begin + std::chrono::duration<double>((step + 1) * kStepS));
    }
    std::printf(
        "{\"reached_s\": %.2f, \"stands\": %s, \"min_clearance_m\": %.3f, \"commands\": %u, \"unusable_commands\": %u}\n",
        reached_s, robot.speed == 0.0 ? "true" : "false", clearance_m, received, refused);
    std::fflush(stdout);
    std::_Exit(0);
}
